"""`python -m acf_jax export`: the peak force for controllers and programs that run no JAX."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from acf_jax.cli._json import echo_json
from acf_jax.cli._origin import OVERWRITE, foreign_files
from acf_jax.errors import InputError

if TYPE_CHECKING:
    from acf_jax.export.formula import Formula

EXAMPLES = """
\b
Examples:
  python -m acf_jax export --c acf_peak.h
  python -m acf_jax export --surrogate surrogate/model.eqx --onnx peak.onnx --c peak.h
"""


@click.command(epilog=EXAMPLES)
@click.option(
    "--surrogate",
    type=click.Path(path_type=Path),
    help="A model.eqx that `train` or train.fit wrote, or `shipped`; without it the exact peak of the paper's model.",
)
@click.option(
    "--c", "header", type=click.Path(path_type=Path), help="Write a C99 header that needs math.h and no more."
)
@click.option(
    "--onnx", "network", type=click.Path(path_type=Path), help="Write the surrogate as an ONNX model."
)
@OVERWRITE
@click.option("--json", "as_json", is_flag=True, help="Print JSON: what was written.")
def command(
    surrogate: Path | None, header: Path | None, network: Path | None, overwrite: bool, as_json: bool
) -> None:
    """Write the exact peak force as C, or a trained surrogate as C and ONNX.

    A surrogate brings its range and its error bound along: outside the range it answers with a flag and an infinite
    force. The documentation's page on export shows each in use.
    """
    if faults := _faults(surrogate, header, network) + foreign_files((header, network), overwrite):
        raise InputError(faults)
    if surrogate is None:
        assert header is not None
        from acf_jax.export.write import write_c

        written = [{"file": str(header), "function": f"{write_c(header)}, C99"}]
    else:
        written = _write_surrogate(surrogate, header, network)
    if as_json:
        echo_json({"written": written})
        return
    for file in written:
        click.echo(f"{file['file']}: {file['function']}")
        if (apart := file.get("relative_difference")) is not None:
            click.echo(
                f"  at most {apart:.1e} relative from JAX over {file['samples_inside']:,} samples of the range; "
                f"{file['samples_outside']:,} outside it are flagged"
            )


def _write_surrogate(surrogate: Path, header: Path | None, network: Path | None) -> list[dict[str, Any]]:
    from acf_jax.start import start_jax

    start_jax()
    from acf_jax.export.formula import read_formula
    from acf_jax.export.write import write_c

    formula = read_formula(None if str(surrogate) == "shipped" else surrogate)
    # ONNX first: it is checked, and where that fails nothing is written
    written = [] if network is None else [_write_onnx(network, formula)]
    if header is not None:
        function = write_c(header, formula, str(surrogate))
        written.append({"file": str(header), "function": f"{function}, C99"})
    return written


def _write_onnx(path: Path, formula: "Formula") -> dict[str, Any]:
    from acf_jax.files import write_bytes

    try:
        from acf_jax.export.onnx_check import check_onnx
        from acf_jax.export.onnx_model import onnx_model
    except ModuleNotFoundError as error:
        raise InputError(
            f"--onnx needs the package {error.name}; run `pip install 'acf-jax[export]'`"
        ) from None
    content = onnx_model(formula).SerializeToString()
    agreement = check_onnx(content, formula)
    write_bytes(path, content)
    return {
        "file": str(path),
        "function": f"x (N, {len(formula.inputs)}) to {', '.join(q.name for q in formula.outputs)}, is_inside",
        "relative_difference": agreement.largest,
        "samples_inside": agreement.inside,
        "samples_outside": agreement.outside,
    }


def _faults(surrogate: Path | None, header: Path | None, network: Path | None) -> list[str]:
    from acf_jax.export.write import c_faults, file_faults

    faults = []
    if header is None and network is None:
        faults.append("nothing to write; name a header by --c, such as --c acf_peak.h, or a model by --onnx")
    if network is not None and surrogate is None:
        faults.append("--onnx writes a surrogate; name one by --surrogate model.eqx, or --surrogate shipped")
    if surrogate is not None and str(surrogate) != "shipped" and not surrogate.is_file():
        remedy = "name a model.eqx that `train` or train.fit wrote, or `shipped`"
        faults.append(f"--surrogate {surrogate}: no such file; {remedy}")
    if header is not None:
        faults += c_faults(header, surrogate is not None, "--c")
    if network is not None:
        faults += file_faults(network, ".onnx", f"--onnx {network}")
    return faults

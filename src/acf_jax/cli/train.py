"""`python -m acf_jax train`: a small network in place of a diagnosis' simulation, with a bound on its error."""

from pathlib import Path

import click

from acf_jax.cli._origin import OVERWRITE, origin
from acf_jax.cli._seed import SEED
from acf_jax.cli._stale import foreign_training
from acf_jax.contact.model_file import ModelFile
from acf_jax.errors import InputError, collected

EXAMPLES = """
\b
Examples:
  python -m acf_jax train diagnosis --out surrogate
  python -m acf_jax train diagnosis --out surrogate --range k_c=4e4,9e4 --range mobility=0,1
  python -m acf_jax export --surrogate surrogate/model.eqx --c peak.h
"""


@click.command(epilog=EXAMPLES)
@click.argument("diagnosis", type=click.Path(path_type=Path))
@click.option(
    "--out", required=True, type=click.Path(path_type=Path), help="Folder for the surrogate and its report."
)
@click.option(
    "--range",
    "ranges",
    multiple=True,
    metavar="NAME=LOW,HIGH",
    help="Another range of v_e, f_p, a fitted parameter, or mobility (1/kg) of a body that recoils; SI units.",
)
@click.option(
    "--samples",
    default=32768,
    show_default=True,
    type=click.IntRange(1024, 2**24),
    help="Simulated impacts to learn from.",
)
@click.option(
    "--steps", default=40_000, show_default=True, type=click.IntRange(1, 10**8), help="Of the optimiser."
)
@click.option("--seed", default=0, show_default=True, type=SEED, help="Of samples, weights and batches.")
@click.option("--resume", is_flag=True, help="Go on from the run's last checkpoint.")
@OVERWRITE
@click.option("--json", "as_json", is_flag=True, help="Print JSON: metrics.json.")
def command(
    diagnosis: Path,
    out: Path,
    ranges: tuple[str, ...],
    samples: int,
    steps: int,
    seed: int,
    resume: bool,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Train a surrogate of the corrected model that `diagnose` left in DIAGNOSIS.

    It learns the peak contact force over what the trials covered and over what the fit leaves open, which is printed
    first. Writes OUT/model.eqx, which `peak`, `speed`, `check`, `design` and `export` take, and OUT/report.html.

    Ends with exit code 1 where the loss diverges.
    """
    faults = []
    if out.exists() and not out.is_dir():
        faults.append(f"--out {out}: is a file; name a folder")
    faults += foreign_training(out, overwrite)
    spans = {name: span for text in ranges if (found := _span(text, faults)) for name, span in [found]}
    file = collected(faults, lambda: ModelFile(diagnosis))
    if file and (not file.is_diagnosis or file.is_trained):
        faults.append(
            f"{diagnosis}: is no diagnosis; name the folder that `diagnose` wrote, or its model.json"
        )
    if faults or file is None:
        raise InputError(faults)
    from acf_jax.start import start_jax

    start_jax()
    from acf_jax.cli._training import train
    from acf_jax.gap_model import read_model
    from acf_jax.provenance import digest_of
    from acf_jax.training.default import default_config

    path, gap = file.path, read_model(file.path)
    made = origin({str(path): digest_of(path)})
    if code := train(
        lambda: default_config(gap, path, out, spans, samples, steps, seed), made, resume, as_json
    ):
        raise click.exceptions.Exit(code)


def _span(text: str, faults: list[str]) -> tuple[str, tuple[float, float]] | None:
    """The name and the range that an option says; a fault is added to `faults`."""
    name, _, span = text.partition("=")
    try:
        low, high = map(float, span.split(","))
    except ValueError:
        faults.append(f"--range {text}: must read NAME=LOW,HIGH, such as --range k_c=4e4,9e4")
        return None
    return name, (low, high)

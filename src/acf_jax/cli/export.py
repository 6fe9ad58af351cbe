"""`python -m acf_jax export`: the exact peak force for controllers that run no Python."""

from pathlib import Path

import click

from acf_jax.cli._json import echo_json
from acf_jax.errors import InputError

EXAMPLES = """
\b
Examples:
  python -m acf_jax export --c acf_peak.h
"""
FUNCTION = "acf_find_peak(m, d, k_f, k_c, v_e, f_p)"


@click.command(epilog=EXAMPLES)
@click.option(
    "--c", "header", type=click.Path(path_type=Path), help="Write a C99 header with the exact peak force."
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON: what was written.")
def command(header: Path | None, as_json: bool) -> None:
    """Write the exact peak force as C: one header, double precision, no dependency but math.h."""
    if header is None:
        raise InputError("--c is missing; name the header to write, such as --c acf_peak.h")
    if header.suffix != ".h":
        raise InputError(f"--c {header}: must end in .h; name a C header")
    if header.is_dir():
        raise InputError(f"--c {header}: is a folder; name a C header in it")

    from acf_jax.export import peak_header
    from acf_jax.files import write_text

    write_text(header, peak_header())
    if as_json:
        echo_json({"written": str(header), "function": FUNCTION, "standard": "C99"})
    else:
        click.echo(f"{header}: {FUNCTION}, C99")

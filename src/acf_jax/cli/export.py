"""`python -m acf_jax export`: the exact peak force for controllers that run no Python."""

from pathlib import Path

import click

from acf_jax.errors import InputError

EXAMPLES = """
\b
Examples:
  python -m acf_jax export --c acf_peak.h
"""


@click.command(epilog=EXAMPLES)
@click.option(
    "--c", "header", type=click.Path(path_type=Path), help="Write a C99 header with the exact peak force."
)
def command(header: Path | None) -> None:
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
    click.echo(f"{header}: acf_find_peak(m, d, k_f, k_c, v_e, f_p), C99")

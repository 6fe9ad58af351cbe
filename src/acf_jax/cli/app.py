"""`python -m acf_jax app`: the whole job in a browser, on this machine."""

from pathlib import Path

import click

EXAMPLES = """
\b
Examples:
  python -m acf_jax app
  python -m acf_jax app sessions /data/recordings --port 8800 --no-browser
"""


@click.command(epilog=EXAMPLES)
@click.argument("folders", nargs=-1, type=click.Path(path_type=Path))
@click.option(
    "--port", default=0, show_default="a free one", type=click.IntRange(0, 65535), help="On this machine."
)
@click.option("--no-browser", is_flag=True, help="Only print the address.")
def command(folders: tuple[Path, ...], port: int, no_browser: bool) -> None:
    """Open, cut, rig, plan, diagnose, use and compare in a browser on this machine.

    Sessions are kept in the first of FOLDERS, by default the folder where the command is given; recordings are opened
    in any of them, and nothing outside is read or written. Only this machine is answered, and only who has the token
    of the address that is printed. Ctrl-C ends it; a diagnosis that runs goes on.
    """
    from acf_jax.errors import InputError

    chosen = list(folders) or [Path()]
    if faults := [
        f"{folder}: is no folder; name one that is there" for folder in chosen if not folder.is_dir()
    ]:
        raise InputError(faults)
    try:
        import starlette  # noqa: F401
        import uvicorn  # noqa: F401
    except ModuleNotFoundError as error:
        raise InputError(f"app needs the package {error.name}; run `pip install 'acf-jax[app]'`") from None
    from acf_jax.app.serve import serve

    serve(chosen, port, not no_browser, click.echo)

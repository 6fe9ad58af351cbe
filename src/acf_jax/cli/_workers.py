"""What commands that work in many processes share."""

import click

WORKERS = click.option(
    "--workers", default=2, show_default=True, type=click.IntRange(1, 1024), help="Processes on this machine."
)
SCHEDULER = click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="A Dask scheduler, such as tcp://host:8786; its workers in place of processes here.",
)


def say(text: str) -> None:
    """On standard error, for who looks on."""
    click.echo(text, err=True)

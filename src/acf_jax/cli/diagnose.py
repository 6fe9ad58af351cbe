"""`python -m acf_jax diagnose`: where the gap to measured impacts lies, why, and how far it shrinks."""

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from acf_jax.diagnosis.search import Progress

EXAMPLES = """
\b
Examples:
  python -m acf_jax diagnose my_rig --out result
  python -m acf_jax diagnose my_rig --out result --json | python -m json.tool
"""


@click.command(epilog=EXAMPLES)
@click.argument("dataset", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder for the results.")
@click.option(
    "--seed", default=0, show_default=True, type=click.IntRange(min=0), help="Of the bootstrap intervals."
)
@click.option("--json", "as_json", is_flag=True, help="Print diagnosis.json as well.")
def command(dataset: Path, out: Path, seed: int, as_json: bool) -> None:
    """Diagnose the sim-to-real gap of the data set in the folder DATASET.

    Writes OUT/diagnosis.json, OUT/report.html and OUT/model.json. docs/data_format.md describes a data set.
    """
    from acf_jax.dataset import read_dataset
    from acf_jax.errors import InputError

    if out.exists() and not out.is_dir():
        raise InputError(f"--out {out}: is a file; name a folder")
    data = read_dataset(dataset)  # faults are told before anything slow is loaded

    from acf_jax.start import start_jax

    start_jax()
    from acf_jax.diagnosis.diagnose import diagnose
    from acf_jax.diagnosis.results import write_results
    from acf_jax.files import whole_folder
    from acf_jax.report import sentence, write_report

    with _progress() as progress:
        diagnosis = diagnose(data, seed, progress)
        progress("writing the report")
        with whole_folder(out) as folder:
            content = write_results(folder, diagnosis)
            write_report(folder / "report.html", diagnosis, content)
    if as_json:
        click.echo(json.dumps(content))
    else:
        click.echo(sentence(diagnosis))
        click.echo(f"{out / 'report.html'}: open it in a browser")


@contextmanager
def _progress() -> Iterator["Progress"]:
    """A line that tells the stage and the time on a terminal; nothing in a pipe."""
    if not sys.stderr.isatty():
        yield lambda stage: None
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("starting", total=None)
        yield lambda stage: bar.update(task, description=stage)

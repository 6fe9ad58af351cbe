"""`python -m acf_jax blind`: check the diagnosis on data whose cause is withheld."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from acf_jax.cli._ending import resumable
from acf_jax.cli._json import echo_json
from acf_jax.cli._progress import counts
from acf_jax.cli._seed import SEED
from acf_jax.cli._workers import SCHEDULER, WORKERS, say

if TYPE_CHECKING:
    from acf_jax.workers import Where

EXAMPLES = """
\b
Examples:
  python -m acf_jax blind --out blind --cases 20
  python -m acf_jax blind seal my_sets
  python -m acf_jax blind score my_sets --out my_score
"""
SCORE_AS_JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON: score.json.")
GOES_ON = "the same command goes on where it was"


@click.group(epilog=EXAMPLES, invoke_without_command=True)
@click.option("--out", type=click.Path(path_type=Path), help="Folder for data sets, diagnoses and score.")
@click.option("--seed", default=1, show_default=True, type=SEED, help="Of all that is drawn.")
@click.option(
    "--cases", default=40, show_default=True, type=click.IntRange(3, 10_000), help="Data sets to draw."
)
@click.option(
    "--world",
    "worlds",
    multiple=True,
    default=["scipy", "mujoco"],
    show_default=True,
    help="Engines that take turns.",
)
@WORKERS
@SCHEDULER
@SCORE_AS_JSON
@click.pass_context
def command(
    context: click.Context,
    out: Path | None,
    seed: int,
    cases: int,
    worlds: tuple[str, ...],
    workers: int,
    scheduler: str | None,
    as_json: bool,
) -> None:
    """Check the diagnosis on data sets whose cause is withheld.

    Draws data sets with a hidden cause from engines that share no code with the fitted simulator, seals the answers,
    diagnoses each as a user would, opens the seal and scores. A run that was stopped goes on where it was.
    """
    if context.invoked_subcommand:
        return
    from acf_jax.errors import InputError

    if out is None:
        raise InputError("--out: is missing; name a folder for the run")
    from acf_jax.blind.campaign import make
    from acf_jax.workers import Where

    where = Where(scheduler, workers, say)
    sets = out / "sets"
    with resumable(GOES_ON):
        with counts() as report:
            make(sets, seed, cases, worlds, where, report)
        _score(sets, out / "results", where, as_json)


@command.command(epilog="Example: python -m acf_jax blind seal my_sets")
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print JSON: the hash.")
def seal(folder: Path, as_json: bool) -> None:
    """Seal the answer.yaml beside each data set of FOLDER, before anyone diagnoses them."""
    from acf_jax.blind.seal import seal_folder

    digest = seal_folder(folder)
    if as_json:
        echo_json({"sha256": digest})
    else:
        click.echo(f"sealed, SHA-256 {digest}")


@command.command(epilog="Example: python -m acf_jax blind score my_sets --out my_score")
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder for diagnoses and score.")
@WORKERS
@SCHEDULER
@SCORE_AS_JSON
def score(folder: Path, out: Path, workers: int, scheduler: str | None, as_json: bool) -> None:
    """Diagnose every data set of FOLDER that has no diagnosis in OUT yet, then open the answers and score.

    The answers are those under the seal of FOLDER, or an answer.yaml beside each data set: `effects: [...]`, and
    `components: [...]` where the cause lies outside the library.
    """
    from acf_jax.workers import Where

    with resumable(GOES_ON):
        _score(folder, out, Where(scheduler, workers, say), as_json)


def _score(folder: Path, results: Path, where: "Where", as_json: bool) -> None:
    import json

    from acf_jax.blind.answer import read_said
    from acf_jax.blind.campaign import diagnose_all
    from acf_jax.blind.page import score_page
    from acf_jax.blind.seal import check_answers, open_answers
    from acf_jax.blind.summary import summarise
    from acf_jax.blind.table import lines
    from acf_jax.dataset import data_sets
    from acf_jax.files import write_text
    from acf_jax.start import start_jax

    digest = check_answers(folder, data_sets(folder))
    if digest and not as_json:
        click.echo(f"answers sealed, SHA-256 {digest}")
    with counts() as report:
        names = diagnose_all(folder, results, where, report)
    # before the answers are opened, since until then a damaged diagnosis can be made again
    said = {name: read_said(results / name) for name in names}
    answers = open_answers(folder, results, names)
    start_jax()
    from acf_jax.blind.score import score_one

    rows = [score_one(folder / name, results / name, said[name], answers[name]) for name in names]
    summary = summarise(rows)
    content = {"score": summary, "rows": rows}
    write_text(results / "score.json", json.dumps(content, indent=1) + "\n")
    text = lines(rows, summary)
    write_text(results / "score.txt", text)
    write_text(results / "score.html", score_page(folder.name, rows, summary))
    if as_json:
        echo_json(content)
        return
    click.echo(text)
    click.echo(f"{results / 'score.html'}: open it in a browser")

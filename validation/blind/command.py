"""What the command `blind` does with its arguments; `acf_jax.cli.blind` has the options."""

import json
from collections.abc import Sequence
from pathlib import Path

import click

from acf_jax.cli._ending import resumable
from acf_jax.cli._json import echo_json
from acf_jax.cli._origin import foreign_files, origin
from acf_jax.cli._progress import counts
from acf_jax.dataset import data_sets
from acf_jax.errors import InputError
from acf_jax.files import write_text
from acf_jax.provenance import FILE, digest_of
from acf_jax.workers import Where
from validation.blind.answer import read_said
from validation.blind.campaign import diagnose_all, make
from validation.blind.page import score_page
from validation.blind.seal import check_answers, open_answers, seal_folder
from validation.blind.summary import summarise
from validation.blind.table import lines

PAGE = "score.html"
GOES_ON = "the same command goes on where it was"


def run(
    out: Path, seed: int, cases: int, worlds: Sequence[str], where: Where, overwrite: bool, as_json: bool
) -> None:
    """Draw data sets with a hidden cause into `out`, seal their answers, diagnose and score."""
    sets = out / "sets"
    _check(out / "results", overwrite)
    with resumable(GOES_ON):
        with counts() as report:
            make(sets, seed, cases, worlds, where, report)
        _score(sets, out / "results", where, as_json)


def seal(folder: Path, as_json: bool) -> None:
    """Seal the answers of a folder, and print their hash."""
    digest = seal_folder(folder)
    if as_json:
        echo_json({"sha256": digest})
    else:
        click.echo(f"sealed, SHA-256 {digest}")


def score(folder: Path, out: Path, where: Where, overwrite: bool, as_json: bool) -> None:
    """Diagnose the data sets of a folder, open their answers and score."""
    _check(out, overwrite)
    with resumable(GOES_ON):
        _score(folder, out, where, as_json)


def _check(results: Path, overwrite: bool) -> None:
    """Refuse a score of others; the page and its origin name the program, and so vouch for what stands beside them."""
    plain = () if (results / PAGE).is_file() else ("score.json", "score.txt")
    if faults := foreign_files((results / name for name in (PAGE, FILE, *plain)), overwrite):
        raise InputError(faults)


def _score(folder: Path, results: Path, where: Where, as_json: bool) -> None:
    digest = check_answers(folder, data_sets(folder))
    if digest and not as_json:
        click.echo(f"answers sealed, SHA-256 {digest}")
    with counts() as report:
        names = diagnose_all(folder, results, where, report)
    # before the answers are opened, since until then a damaged diagnosis can be made again
    said = {name: read_said(results / name) for name in names}
    answers = open_answers(folder, results, names)
    from acf_jax.start import start_jax

    start_jax()
    from validation.blind.score import score_one

    rows = [score_one(folder / name, results / name, said[name], answers[name]) for name in names]
    summary = summarise(rows)
    content = {"score": summary, "rows": rows}
    write_text(results / "score.json", json.dumps(content, indent=1) + "\n")
    text = lines(rows, summary)
    write_text(results / "score.txt", text)
    made = origin({str(folder): digest_of(folder)})
    write_text(results / PAGE, score_page(folder.name, rows, summary, str(made)))
    made.write(results)
    if as_json:
        echo_json(content)
        return
    click.echo(text)
    click.echo(f"{results / PAGE}: open it in a browser")

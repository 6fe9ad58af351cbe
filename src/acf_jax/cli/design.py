"""`python -m acf_jax design`: the pretension, and what else is free, that is best within a force limit."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from acf_jax.cli._json import echo_json
from acf_jax.cli._origin import OVERWRITE, foreign_files
from acf_jax.cli._progress import stages
from acf_jax.contact.model_file import ModelFile
from acf_jax.errors import InputError

if TYPE_CHECKING:
    from acf_jax.contact.model import ContactModel
    from acf_jax.designs.config import Config, Question

EXAMPLES = """
\b
Examples:
  python -m acf_jax design --config design.yaml
  python -m acf_jax design --config design.yaml --plot design.html --json
"""


@click.command(epilog=EXAMPLES)
@click.option(
    "--config", required=True, type=click.Path(path_type=Path), help="YAML file: model, goal, limit, ranges."
)
@click.option("--plot", type=click.Path(path_type=Path), help="Write the design space to this HTML file.")
@OVERWRITE
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(config: Path, plot: Path | None, overwrite: bool, as_json: bool) -> None:
    """Design an impact within a force limit, as the documentation's page on design explains.

    Ends with exit code 1 where nothing in the ranges is feasible, after saying what would make it so, and where a
    scan of the ranges knows a better point than the search.
    """
    faults = foreign_files([plot], overwrite)
    if plot is not None and plot.suffix.lower() not in (".html", ".htm"):
        faults.append(f"--plot {plot}: must end in .html; name an HTML file")
    question, model = _read(config, faults)
    _answer(question, model, plot, as_json)


def _answer(config: "Config", model: "ContactModel", plot: Path | None, as_json: bool) -> None:
    from acf_jax.designs.answer import answer
    from acf_jax.designs.remedy import Infeasible
    from acf_jax.report import design_text as words

    with stages() as progress:
        progress("searching the ranges")
        found = answer(config, model)
        if plot is not None:
            from acf_jax.report.design_plot import write_design_plot

            progress("drawing the ranges")
            write_design_plot(plot, found)
    if as_json:
        echo_json(words.none_document(found) if isinstance(found, Infeasible) else words.document(found))
    else:
        click.echo(words.explanation(found) if isinstance(found, Infeasible) else words.text(found))
    if isinstance(found, Infeasible) or not found.is_best:
        raise click.exceptions.Exit(1)


def _read(path: Path, faults: list[str]) -> "tuple[Config, ContactModel]":
    """The configuration and the model that it names; `InputError` with the faults of both and those known before."""
    from acf_jax.designs.config import read_question

    model = None
    try:
        question = read_question(path)
        faults += question.faults
        if (file := _model_file(path, question, faults)) is not None:
            from acf_jax.start import start_jax

            start_jax()
            model = file.load()
            from acf_jax.designs.answer import model_faults

            faults += model_faults(path, question, model)
    except InputError as error:
        raise InputError([*faults, *error.faults]) from None
    if faults or question.config is None or model is None:
        raise InputError(faults)
    return question.config, model


def _model_file(path: Path, question: "Question", faults: list[str]) -> ModelFile | None:
    """The model that a question names, sound or not in all else; None where it names no sound one."""
    name, surrogate = (question.content.get(key) for key in ("model", "surrogate"))
    if not isinstance(name, str):
        return None
    beside = Path(surrogate) if isinstance(surrogate, str) else None
    if beside is not None and surrogate != "shipped":
        beside = path.parent / beside
    # without a sound configuration the model is read for its faults and for its parameters' names alone
    config = question.config
    std = config.relative_std if config else dict.fromkeys(question.names("relative_std"), 0.0)
    for given in (std, {}):
        try:
            return ModelFile(path.parent / name, given, beside)
        except InputError as error:
            faults += [fault for fault in error.faults if fault not in faults]
    return None

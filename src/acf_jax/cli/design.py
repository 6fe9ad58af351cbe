"""`python -m acf_jax design`: the pretension, and what else is free, that is best within a force limit."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from acf_jax.cli._json import echo_json
from acf_jax.cli._model import ModelFile
from acf_jax.cli._progress import stages
from acf_jax.errors import InputError

if TYPE_CHECKING:
    from acf_jax.contact.model import ContactModel
    from acf_jax.design.config import Config

EXAMPLES = """
\b
Examples:
  python -m acf_jax design --config configs/design.yaml
  python -m acf_jax design --config configs/design.yaml --plot design.html --json
"""


@click.command(epilog=EXAMPLES)
@click.option(
    "--config", required=True, type=click.Path(path_type=Path), help="YAML file: model, goal, limit, ranges."
)
@click.option("--plot", type=click.Path(path_type=Path), help="Write the design space to this HTML file.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(config: Path, plot: Path | None, as_json: bool) -> None:
    """Design an impact within a force limit: docs/design.md explains the question and the answer.

    Ends with exit code 1 where nothing in the ranges is feasible, after saying what would make it so.
    """
    faults = []
    if plot is not None and plot.suffix.lower() not in (".html", ".htm"):
        faults.append(f"--plot {plot}: must end in .html; name an HTML file")
    question, file = _read(config, faults)

    from acf_jax.start import start_jax

    start_jax()
    _answer(question, file.load(), config, plot, as_json)


def _answer(config: "Config", model: "ContactModel", where: Path, plot: Path | None, as_json: bool) -> None:
    from acf_jax.cli import _design_text as words
    from acf_jax.design.remedy import Infeasible
    from acf_jax.design.solve import design
    from acf_jax.design.task import make_task

    ranges = {name: (r.low, r.high) for name, r in config.ranges().items()}
    fixed = {name: value for name in ("v_e", "f_p") if isinstance(value := getattr(config, name), float)}
    given = ranges | {name: (value, value) for name, value in fixed.items()}
    if faults := _range_faults(where, ranges, model.names) or _learnt_faults(where, given, model):
        raise InputError(faults)
    task = make_task(model, ranges, fixed, config.goal, config.limit, config.probability)
    with stages() as progress:
        progress("searching the ranges")
        found = design(task, config.starts, config.draws, config.seed)
    if isinstance(found, Infeasible):
        if as_json:
            echo_json(words.infeasible_document(found))
        else:
            click.echo(words.explanation(found))
        raise click.exceptions.Exit(1)
    if plot is not None:
        from acf_jax.cli._design_plot import write_design_plot

        write_design_plot(plot, found)
    if as_json:
        echo_json(words.document(found))
    else:
        click.echo(words.text(found))


def _read(path: Path, faults: list[str]) -> tuple["Config", ModelFile]:
    """The configuration and the model that it names; `InputError` with the faults of both and those known before."""
    from acf_jax.design.config import read_config

    try:
        config = read_config(path)
        surrogate = config.surrogate
        if surrogate is not None and str(surrogate) != "shipped":
            surrogate = path.parent / surrogate
        file = ModelFile(path.parent / config.model, config.relative_std, surrogate)
    except InputError as error:
        raise InputError([*faults, *error.faults]) from None
    if faults:
        raise InputError(faults)
    return config, file


def _range_faults(where: Path, ranges: dict[str, tuple[float, float]], names: tuple[str, ...]) -> list[str]:
    faults = [
        f"{where}: free.{name}: is not a parameter of the model; known are {', '.join(names[:-2])}"
        for name in ranges
        if name not in names
    ]
    return faults + [
        f"{where}: free.{name}: low must be above 0; the model needs a positive {name}"
        for name, (low, _) in ranges.items()
        if name in ("m", "k_c") and low == 0
    ]


def _learnt_faults(where: Path, given: dict[str, tuple[float, float]], model: "ContactModel") -> list[str]:
    """Ranges that a surrogate was not trained for."""
    from acf_jax.contact.read import learnt_range

    known = {name: learnt_range(model, name) for name in given}
    return [
        f"{where}: {name}: {low:g} to {high:g} leaves the surrogate's {learnt[0]:g} to {learnt[1]:g}; narrow it, or"
        " name the diagnosis' model.json as model"
        for name, (low, high) in given.items()
        if (learnt := known[name]) is not None and not learnt[0] <= low <= high <= learnt[1]
    ]

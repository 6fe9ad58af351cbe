"""`python -m acf_jax blind`: check the diagnosis on data whose cause is withheld.

The work is that of `validation.blind`, which no one but a developer needs: it stays in the repository.
"""

import sys
from pathlib import Path
from types import ModuleType

import click

import acf_jax
from acf_jax.cli._group import Group
from acf_jax.cli._origin import OVERWRITE
from acf_jax.cli._seed import SEED
from acf_jax.cli._workers import SCHEDULER, WORKERS, say

EXAMPLES = """
\b
Examples:
  python -m acf_jax blind --out blind --cases 20
  python -m acf_jax blind seal my_sets
  python -m acf_jax blind score my_sets --out my_score
"""
SCORE_AS_JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON: score.json.")
ELSEWHERE = "blind: is not installed; run it in a copy of acf-jax's source repository, whose folder validation/ has it"


@click.group(cls=Group, epilog=EXAMPLES, invoke_without_command=True)
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
@OVERWRITE
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
    overwrite: bool,
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
    from acf_jax.workers import Where

    _program().run(out, seed, cases, worlds, Where(scheduler, workers, say), overwrite, as_json)


@command.command(epilog="Example: python -m acf_jax blind seal my_sets")
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print JSON: the hash.")
def seal(folder: Path, as_json: bool) -> None:
    """Seal the answer.yaml beside each data set of FOLDER, before anyone diagnoses them."""
    _program().seal(folder, as_json)


@command.command(epilog="Example: python -m acf_jax blind score my_sets --out my_score")
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder for diagnoses and score.")
@WORKERS
@SCHEDULER
@OVERWRITE
@SCORE_AS_JSON
def score(
    folder: Path, out: Path, workers: int, scheduler: str | None, overwrite: bool, as_json: bool
) -> None:
    """Diagnose every data set of FOLDER that has no diagnosis in OUT yet, then open the answers and score.

    The answers are those under the seal of FOLDER, or an answer.yaml beside each data set: `effects: [...]`, and
    `components: [...]` where the cause lies outside the library.
    """
    from acf_jax.workers import Where

    _program().score(folder, out, Where(scheduler, workers, say), overwrite, as_json)


def _program() -> ModuleType:
    """What does the work, from the repository that this package or the caller is in."""
    for folder in (Path(acf_jax.__file__).parent / "../..", Path()):
        if (folder / "validation/blind/command.py").is_file():
            if sys.path[0] != (place := str(folder.resolve())):
                sys.path.insert(0, place)  # processes on this machine inherit it
            from validation.blind import command

            return command
    from acf_jax.errors import InputError

    raise InputError(ELSEWHERE)

"""`python -m acf_jax speed`: the highest contact velocity for a force limit, the paper's inverse."""

from pathlib import Path

import click

from acf_jax.cli._json import echo_json
from acf_jax.cli._progress import counted
from acf_jax.cli._rig import option
from acf_jax.cli._stop import ending_options, make_ending
from acf_jax.contact.model_file import HELP, ModelFile
from acf_jax.errors import InputError, collected

EXAMPLES = """
\b
Examples:
  python -m acf_jax speed --model rig.yaml --f-p 100 --limit 150 --limit 250
  python -m acf_jax speed --model result/model.json --f-p 80 --limit 140 --probability 0.99
"""


@click.command(epilog=EXAMPLES)
@click.option("--model", "--rig", "model_file", required=True, type=click.Path(path_type=Path), help=HELP)
@click.option("--f-p", required=True, type=float, help="Pretension F_P, N.")
@click.option(
    "--limit",
    required=True,
    type=float,
    multiple=True,
    help="Highest peak contact force, N; may be repeated.",
)
@ending_options
@click.option("--probability", default=0.95, show_default=True, type=float, help="That the limit holds.")
@click.option(
    "--draws",
    default=8192,
    show_default=True,
    type=click.IntRange(256, 2**20),
    help="Of everything uncertain; more where the probability needs them, which a simulated model has to be told.",
)
@click.option("--up-to", default=2.0, show_default=True, type=float, help="Highest velocity looked at, m/s.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    model_file: Path,
    f_p: float,
    limit: tuple[float, ...],
    stop_after: float | None,
    travel: float | None,
    reaction: float | None,
    deceleration: float | None,
    probability: float,
    draws: int,
    up_to: float,
    as_json: bool,
) -> None:
    """Highest contact velocity for a limit of the peak contact force, exact, under the parameters' uncertainty.

    The force of the first peak counts, and the answer says when the robot must have stopped so that the limit holds
    with the same probability for what follows, too; where it is stated how the contact ends, the force until then
    counts.

    Ends with exit code 1 where no velocity keeps one of the limits.
    """
    from acf_jax.designs.asked import Asked, asked_faults

    ending, faults = make_ending(
        stop_after=stop_after, travel=travel, reaction=reaction, deceleration=deceleration
    )
    file = collected(faults, lambda: ModelFile(model_file))
    asked = Asked(f_p, limit, ending, probability, draws, up_to)
    faults = asked_faults(asked, option) + faults
    if faults or file is None:
        raise InputError(faults)

    from acf_jax.start import start_jax

    start_jax()
    from acf_jax.designs.solve import Design
    from acf_jax.designs.speed import find_speeds
    from acf_jax.report import speed_text as words

    model = file.load()
    speeds = find_speeds(model, asked, option, lambda limits: counted(limits, "limits"))
    if as_json:
        rows = [words.document(x) for x in speeds.found]
        about = {"model": model.source, "f_p": f_p, "probability": probability}
        echo_json(about | {"speeds": rows, "notes": list(speeds.notes)})
    else:
        click.echo(words.text(speeds, ending.is_known))
    if not all(isinstance(x, Design) for x in speeds.found):
        raise click.exceptions.Exit(1)

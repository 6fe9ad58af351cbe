"""`python -m acf_jax speed`: the highest contact velocity for a force limit, the paper's inverse."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from acf_jax.cli._json import echo_json
from acf_jax.cli._model import HELP, ModelFile
from acf_jax.cli._progress import counted
from acf_jax.cli._rig import value_fault
from acf_jax.cli._stop import ending_options, make_ending
from acf_jax.errors import InputError

if TYPE_CHECKING:
    from acf_jax.design.remedy import Infeasible
    from acf_jax.design.solve import Design

EXAMPLES = """
\b
Examples:
  python -m acf_jax speed --model configs/table1_rig.yaml --f-p 100 --limit 150 --limit 250
  python -m acf_jax speed --model result/model.json --f-p 80 --limit 140 --probability 0.99
"""


@click.command(epilog=EXAMPLES)
@click.option("--model", "model_file", required=True, type=click.Path(path_type=Path), help=HELP)
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

    The force of the first peak counts, and the answer says when the robot must have stopped so that no later force
    passes the limit; where it is stated how the contact ends, the force until then counts.

    Ends with exit code 1 where no velocity keeps one of the limits.
    """
    faults = []
    faults += [fault] if (fault := value_fault("f_p", f_p, "--f-p")) else []
    faults += [fault for x in limit if (fault := value_fault("limit", x, "--limit"))]
    if not 0.5 <= probability <= 0.9999:
        faults.append(f"--probability must lie between 0.5 and 0.9999, but is {probability!r}")
    if up_to <= 0:
        faults.append(f"--up-to must be above 0 m/s, but is {up_to!r}")
    elif fault := value_fault("v_e", up_to, "--up-to"):
        faults.append(fault)
    ending, wrong = make_ending(
        stop_after=stop_after, travel=travel, reaction=reaction, deceleration=deceleration
    )
    faults += wrong
    file = None
    try:
        file = ModelFile(model_file)
    except InputError as error:
        faults += error.faults
    if faults or file is None:
        raise InputError(faults)

    from acf_jax.start import start_jax

    start_jax()
    from acf_jax.contact.ended import ended
    from acf_jax.contact.read import learnt_range
    from acf_jax.contact.stop import ending_conflict
    from acf_jax.design.chance import draws_fault
    from acf_jax.design.solve import Design, design
    from acf_jax.design.task import make_task

    model = file.load()
    slowest, fastest = learnt_range(model, "v_e") or (0.0, up_to)
    least, most = learnt_range(model, "f_p") or (f_p, f_p)
    if not least <= f_p <= most:
        faults.append(f"--f-p must lie in the surrogate's {least:g} to {most:g} N, but is {f_p:g}")
    if fault := draws_fault(model, probability, draws):
        faults.append(f"--draws: {fault}")
    if slowest >= up_to:
        faults.append(f"--up-to must be above the surrogate's {slowest:g} m/s, but is {up_to:g}")
    if faults:
        raise InputError(faults)
    if fault := ending_conflict(model, ending, 0.0):
        raise InputError(fault)
    if ending.is_known:
        model = ended(model, ending)
    is_cut, up_to = slowest > 0 or fastest < up_to, min(up_to, fastest)
    found = [
        design(
            make_task(model, {"v_e": (slowest, up_to)}, {"f_p": f_p}, "fastest", force, probability),
            draws=draws,
        )
        for force in counted(limit, "limits")
    ]
    notes = list(dict.fromkeys(note for x in found if isinstance(x, Design) for note in x.notes))
    if is_cut and not all(isinstance(x, Design) and x.at_limit for x in found):
        notes.append(
            f"no velocity outside the surrogate's range of {slowest:g} to {fastest:g} m/s is looked at"
        )
    if as_json:
        rows = [_row(x) for x in found]
        echo_json(
            {"model": model.source, "f_p": f_p, "probability": probability, "speeds": rows, "notes": notes}
        )
    else:
        click.echo(
            "       limit    highest velocity    expected force    one newton more    draws within"
            f"    robot {'stops' if ending.is_known else 'must stop'} within"
        )
        for x in found:
            click.echo(f"{x.task.limit:10.4g} N   {_words(x) if isinstance(x, Design) else _why_none(x)}")
        for note in notes:
            click.echo(f"note: {note}")
    if not all(isinstance(x, Design) for x in found):
        raise click.exceptions.Exit(1)


def _row(found: "Design | Infeasible") -> dict[str, Any]:
    """The answer to one limit for programs."""
    from acf_jax.cli._design_text import stop_document
    from acf_jax.design.solve import Design

    row = {"limit_n": found.task.limit, "probability_among_fresh_draws": found.probability}
    if isinstance(found, Design):
        return row | {
            "v_e": float(found.z[-2]),
            "expected_force_n": found.force,
            "v_e_per_n": found.goal_per_newton,
            "limit_reached": found.at_limit,
            **stop_document(found),
        }
    none = dict.fromkeys(
        (
            "v_e",
            "expected_force_n",
            "v_e_per_n",
            "limit_reached",
            "robot_stops_within_s",
            "robot_stops_within_m",
        )
    )
    return row | none | {"least_force_n": found.upper, "least_loaded_v_e": float(found.z[-2])}


def _words(found: "Design") -> str:
    from acf_jax.contact.read import learnt_range

    speed = math.floor(found.z[-2] * 1e4) / 1e4  # not rounded up: what is shown is allowed
    price = f"{found.goal_per_newton:.5f} m/s" if found.goal_per_newton is not None else "-"
    line = f"{speed:12.4f} m/s {found.force:15.2f} N {price:>18} {found.probability:15.4f}    {_stop(found)}"
    if found.at_limit:
        return line
    task = found.task
    if found.z[-2] < task.high[0]:
        why = f"beyond, {task.model.main.peak.no_peak}"
    else:
        known = learnt_range(task.model, "v_e")
        why = "the surrogate's range ends" if known and known[1] <= task.high[0] else "the search's end"
    return f"{line}    limit not reached: {why}"


def _stop(found: "Design") -> str:
    """When the robot stops, or has to, so that no later force passes the limit."""
    from acf_jax.contact.stop import LONGEST, stop_words

    if found.stop is None:
        return "no stop is soon enough"
    return stop_words(found.stop) if math.isfinite(found.stop.time) else f"not within {LONGEST:g} s"


def _why_none(found: "Infeasible") -> str:
    if not found.has_peak:
        return f"none: at every velocity {found.task.model.main.peak.no_peak}; raise the pretension"
    slowest, v_e = found.task.low[0], found.z[-2]
    how = (
        "pressing without speed"
        if v_e == 0
        else f"{v_e:.4g} m/s" + (", the lowest," if v_e == slowest else "")
    )
    if not math.isfinite(found.upper):
        share = 100 * found.without_peak
        return f"none: with {how} {share:.2g} % of the draws have no first peak; raise the pretension"
    return f"none: {how} takes {found.upper:.4g} N already; lower the pretension"

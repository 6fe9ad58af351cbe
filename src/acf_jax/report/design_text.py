"""A design in words and as a document."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from acf_jax.contact.read import learnt_range
from acf_jax.contact.stop import LONGEST, stop_words

if TYPE_CHECKING:
    from acf_jax.designs.remedy import Infeasible
    from acf_jax.designs.solve import Design, Sensitivity
    from acf_jax.designs.task import Task

GOALS = {
    "fastest": "Fastest contact",
    "highest_process_force": "Highest process force",
    "widest_margin": "Widest margin",
}
ROUNDING = 1e-9  # what is left of a condition, or in N of the limit, below which only rounding is left


def text(found: "Design") -> str:
    """What a person reads of a design."""
    task, model = found.task, found.task.model
    lines = [f"{GOALS[task.goal]} within {task.limit:g} N:"]
    lines += [f"  {name:8} {value}" for name, value in values_said(found)]
    lines += [
        f"peak contact force: {found.force:.1f} N expected, {found.upper:.1f} N not exceeded with a probability of"
        f" {task.probability:g}",
        f"  ({found.probability:.4f} of {found.draws:,} fresh draws hold the limit)",
    ]
    lines.append(stop_said(found))
    if found.goal_per_newton is not None:
        name = "v_e" if task.goal == "fastest" else "f_p"
        unit = model.units[model.names.index(name)]
        lines.append(f"one newton more of limit is worth {found.goal_per_newton:.2g} {unit} of {name}")
    elif task.goal != "widest_margin" and not found.at_limit:
        lines.append(f"the limit is not reached: {_why_not_reached(found)}")
    lines += ["", *_costs(found.sensitivities), "", f"search: {_search(found)}"]
    if found.residual is not None:
        within = "rounding" if found.residual < ROUNDING else f"{found.residual:.1g}"
        slack = 0.0 if found.slack < ROUNDING else found.slack
        lines.append(f"optimum: its conditions hold within {within}, {_round(slack)} N of the limit are left")
    lines += [f"note: {note}" for note in found.notes]
    return "\n".join(lines)


def values_said(found: "Design | Infeasible") -> list[tuple[str, str]]:
    """What was free, with its value and unit; the goal is not rounded up."""
    task, said = found.task, []
    for i, low, high in zip(task.free, task.low, task.high, strict=True):
        value = found.z[i]
        end = (
            " (low end of its range)" if value == low else " (high end of its range)" if value == high else ""
        )
        is_goal = task.coordinate is not None and task.free[task.coordinate] == i
        shown = _down(value) if is_goal and not end else _round(value)
        said.append((task.model.names[i], f"{shown} {task.model.units[i]}{end}"))
    return said


def stop_said(found: "Design") -> str:
    """The stop that the answer takes for granted."""
    if found.stop is None:
        return "the force goes on rising from its first peak: no stop of the robot is soon enough"
    if math.isinf(found.stop.time):
        return f"the robot need not stop within {LONGEST:g} s"
    return f"the robot must have stopped {stop_words(found.stop)} after first contact"


def _why_not_reached(found: "Design") -> str:
    task = found.task
    assert task.coordinate is not None
    i = task.free[task.coordinate]
    name, high = task.model.names[i], task.high[task.coordinate]
    if found.z[i] == high:
        known = learnt_range(task.model, name)
        return (
            "the surrogate's range ends there"
            if known and high >= known[1]
            else "widen the ranges to gain more"
        )
    among = "in too many draws " if found.margin.reach else ""
    return f"with a higher {name} {among}{task.model.main.peak.no_peak}"


def _costs(rows: Sequence["Sensitivity"]) -> list[str]:
    """The table of sensitivities."""
    width = max(len(row.name) for row in rows)
    lines = [f"{'what costs newtons':{width}}      value  uncertain by   N per 1 %   N of margin"]
    for row in rows:
        value, std, per_percent = (
            "-" if x is None else shown(x)
            for x, shown in (
                (row.value, _round),
                (row.std, "{:.4g}".format),
                (row.per_percent, "{:.3f}".format),
            )
        )
        lines.append(f"{row.name:{width}} {value:>10}  {std:>12}  {per_percent:>10}  {row.margin:12.3f}")
    return lines


def _search(found: "Design") -> str:
    s = found.search
    scan = f"of {s.scanned:,} more points over the ranges, {s.better} are allowed and better"
    if found.task.is_line:
        return f"the limit's first crossing, to the last digit; {scan}"
    again = f", {s.again} more from better points of a scan" if s.again else ""
    return f"{s.reached} of {s.starts} starts end at this goal{again}; {scan}"


def explanation(found: "Infeasible") -> str:
    """Why there is no design, and what would make one."""
    task, model = found.task, found.task.model
    at = ", ".join(f"{model.names[i]} = {_round(found.z[i])} {model.units[i]}" for i in task.free)
    lines = [
        f"Not feasible: no point of the ranges meets {task.limit:g} N with a probability of {task.probability:g}."
    ]
    if not found.has_peak:
        lines.append(f"  Everywhere {model.main.peak.no_peak}: the model has no answer there.")
    upper = f"{found.upper:.1f} N not exceeded" if math.isfinite(found.upper) else "no force is kept"
    lines += [
        f"  Least loaded at {at}: {found.force:.1f} N expected, {upper}"
        f" (the limit holds with a probability of {found.probability:.3f}).",
    ]
    if found.has_peak and found.without_peak:
        lines.append(
            f"  In {100 * found.without_peak:.2g} % of the draws there {model.main.peak.original().no_peak}."
        )
    lines += [
        f"  None of {found.scanned:,} points over the ranges is allowed either.",
        "Any one of these would do there:" if found.remedies else "No single change would do.",
    ]
    lines += [f"  {line}" for line in remedies_said(found)]
    return "\n".join(lines)


def remedies_said(found: "Infeasible") -> list[str]:
    """Each change that alone would do, rounded to the safe side."""
    said = []
    for r in found.remedies:
        way, value = ("raise", _up(r.needed)) if r.needed > r.now else ("lower", _down(r.needed))
        said.append(f"{way} {r.name} from {_round(r.now)} to {value} {r.unit}")
    return said


def _asked(task: "Task", feasible: bool) -> dict[str, Any]:
    """What was asked for, and whether it can be had."""
    return {
        "schema": "acf-design/1",
        "feasible": feasible,
        "model": task.model.source,
        "goal": task.goal,
        "limit_n": task.limit,
        "probability": task.probability,
    }


def document(found: "Design") -> dict[str, Any]:
    """A design for programs."""
    task, model = found.task, found.task.model
    return {
        **_asked(task, feasible=True),
        "optimum": {model.names[i]: float(found.z[i]) for i in task.free},
        "all_values": {name: float(value) for name, value in zip(model.names, found.z, strict=True)},
        "force_n": found.force,
        "force_not_exceeded_n": found.upper,
        "force_std_n": found.std,
        "probability_among_fresh_draws": found.probability,
        "draws": found.draws,
        "goal_per_newton": found.goal_per_newton,
        "limit_reached": found.at_limit,
        "limit_slack_n": found.slack,
        **stop_document(found),
        "optimality_residual": found.residual,
        "sensitivities": [row._asdict() for row in found.sensitivities],
        "search": {
            "starts": found.search.starts,
            "reached": found.search.reached,
            "again": found.search.again,
            "scanned": found.search.scanned,
            "scanned_better": found.search.better,
        },
        "notes": list(found.notes),
    }


def stop_document(found: "Design") -> dict[str, float | None]:
    """The stop of the robot that the answer takes for granted; None where it is not bounded, or none is soon enough."""
    told = found.stop is not None and math.isfinite(found.stop.time)
    time, travel = (found.stop.time, found.stop.travel) if found.stop and told else (None, None)
    return {"robot_stops_within_s": time, "robot_stops_within_m": travel}


def none_document(found: "Infeasible") -> dict[str, Any]:
    """Infeasibility for programs."""
    task, model = found.task, found.task.model
    return {
        **_asked(task, feasible=False),
        "least_loaded": {name: float(value) for name, value in zip(model.names, found.z, strict=True)},
        "force_n": found.force,
        "force_not_exceeded_n": found.upper,
        "probability_there": found.probability,
        "without_peak_there": found.without_peak,
        "scanned": found.scanned,
        "remedies": [r._asdict() for r in found.remedies],
    }


def _round(value: float) -> str:
    return f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"


def _down(value: float) -> str:
    """Four digits, rounded so that what is shown still works."""
    if value == 0:
        return "0"
    step = 10.0 ** (math.floor(math.log10(abs(value))) - 3)
    return _round(math.floor(value / step) * step)


def _up(value: float) -> str:
    step = 10.0 ** (math.floor(math.log10(abs(value))) - 3)
    return _round(math.ceil(value / step) * step)

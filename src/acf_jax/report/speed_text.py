"""Highest contact velocities in words and as a document."""

import math
from collections.abc import Sequence
from typing import Any

from acf_jax.contact.ended import Ended
from acf_jax.contact.read import learnt_range
from acf_jax.contact.stop import LONGEST, stop_words
from acf_jax.designs.remedy import Infeasible
from acf_jax.designs.solve import Design
from acf_jax.designs.speed import Speeds
from acf_jax.report.design_text import stop_document

Found = Design | Infeasible


def text(speeds: Speeds, is_ended: bool) -> str:
    """What a person reads of the answers. `is_ended`: it is stated how the contact ends."""
    lines = lines_of("limit", [(x.task.limit, x) for x in speeds.found], is_ended)
    return "\n".join([*lines, *(f"note: {note}" for note in speeds.notes)])


def lines_of(what: str, found: Sequence[tuple[float, Found]], is_ended: bool = False) -> list[str]:
    """A table of answers, each behind a force in N that tells it from the others; `what`: that force's name."""
    stops = f"robot {'stops' if is_ended else 'must stop'} within"
    head = f"{what:>12}    highest velocity    expected force    one newton more    draws within    {stops}"
    return [
        head,
        *(f"{n:10.4g} N   {_words(x) if isinstance(x, Design) else why_none(x)}" for n, x in found),
    ]


def document(found: Found) -> dict[str, Any]:
    """The answer to one limit for programs."""
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


def _words(found: Design) -> str:
    price = f"{found.goal_per_newton:.5f} m/s" if found.goal_per_newton is not None else "-"
    line = f"{speed(found):>16} {found.force:15.2f} N {price:>18} {found.probability:15.4f}    {stop(found)}"
    return line if found.at_limit else f"{line}    {why_end(found)}"


def speed(found: Design) -> str:
    """The velocity, not rounded up: what is shown is allowed."""
    return f"{math.floor(found.z[-2] * 1e4) / 1e4:.4f} m/s"


def why_end(found: Design) -> str:
    """Why the limit is not reached; empty where it is."""
    task = found.task
    if found.at_limit:
        return ""
    if found.z[-2] < task.high[0]:
        why = f"beyond, {task.model.main.peak.no_peak}"
    else:
        known = learnt_range(task.model, "v_e")
        why = "the surrogate's range ends" if known and known[1] <= task.high[0] else "the search's end"
    return f"limit not reached: {why}"


def stop(found: Design) -> str:
    """When the robot stops, or has to, so that what follows the first peak keeps the limit, too."""
    if found.stop is None:
        return "no stop is soon enough"
    return (
        stop_words(found.stop) if math.isfinite(found.stop.time) else f"no stop within {LONGEST:g} s needed"
    )


def why_none(found: Infeasible) -> str:
    """Why no velocity keeps the limit."""
    peak = found.task.model.main.peak
    without = peak.no_peak if isinstance(peak, Ended) else f"{peak.no_peak}; raise the pretension"
    if not found.has_peak:
        return f"none: at every velocity {without}"
    slowest, v_e = found.task.low[0], found.z[-2]
    how = (
        "pressing without speed"
        if v_e == 0
        else f"{v_e:.4g} m/s" + (", the lowest," if v_e == slowest else "")
    )
    if not math.isfinite(found.upper):
        share = 100 * found.without_peak
        return f"none: with {how}, in {share:.2g} % of the draws {without}"
    return f"none: {how} takes {found.upper:.4g} N already; lower the pretension"

"""Verdicts in words, as a document and as a table."""

import csv
import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acf_jax.dataset.table import records_of
from acf_jax.files import read_text
from acf_jax.safety.situation import OF_ENDING, OF_VERDICT

if TYPE_CHECKING:
    from acf_jax.safety.check import Answer, Checker
    from acf_jax.safety.limits import Limits

NO_AREA = "not decided"


def text(answer: "Answer", checker: "Checker", limits: "Limits") -> str:
    """What a person reads of one verdict."""
    from acf_jax.safety.assumptions import STATEMENT

    a, s = answer, answer.situation
    kind = "transient" if s.contact == "transient" else "quasi-static"
    lines = [
        f"{a.verdict.capitalize()}: {a.area.name} ({a.area.region}), {kind} contact at {s.v_e:g} m/s with"
        f" {s.f_p:g} N of pretension"
    ]
    lines += [f"  because  {reason}" for reason in a.reasons if a.verdict != "allowed"]
    lines += [f"  caution  {caution}" for caution in a.cautions]
    if a.force_limit is not None:
        if a.force is not None:
            lines.append(
                f"  force    {a.force:.1f} N expected, {a.upper:.1f} N not exceeded with a confidence of"
                f" {checker.confidence:g}; limit {a.force_limit:g} N"
            )
        if a.lasting is not None:
            lines.append(f"  lasting  {a.lasting:.1f} N expected once the robot has stopped")
        lines.append(f"  pressure {_pressure(a)}")
        until = "" if s.ending.is_known else ", however long it lasts"
        highest = highest_said(*checker.highest_speed(s))
        lines.append(f"  highest velocity allowed here{until}, by this model: {highest}")
        lines.append(f"  ISO/TS 15066's own formula: {_standard(a)}")
        lines.append(f"  decided by the {a.decided_by}; limits of {limits.source}")
        lines.append("It takes for granted that")
        lines += [f"  - {line}" for line in _assumptions(a, checker)]
    return "\n".join([*lines, STATEMENT])


def highest_said(v: float | None, ended_by: str | None) -> str:
    """The highest velocity at which a contact is allowed, in words; arguments as of `HighestSpeed`."""
    if v is None:
        return "none"
    speed = f"{math.floor(v * 1e3) / 1e3:.3f} m/s"  # not rounded up: what is shown is allowed
    return speed if ended_by == "verdict" else f"{speed} and perhaps more, the {ended_by} ends there"


def _pressure(a: "Answer") -> str:
    if a.pressure_limit is None:
        return "not decided: the limits name no pressure for this area"
    if a.situation.contact_area is None:
        return f"not decided: no contact area is given (limit {a.pressure_limit:g} N/cm^2)"
    if a.pressure is None:
        return "not decided: no force is known"
    return f"{a.pressure:.1f} N/cm^2 not exceeded; limit {a.pressure_limit:g} N/cm^2"


def _standard(a: "Answer") -> str:
    if a.standard_speed is None:
        if a.situation.contact != "transient":
            return "not computed: it is for a body that can recoil"
        return "not computed: it needs --robot-mass-kg and --payload-kg"
    return f"v_max = {a.standard_speed:.2f} m/s (without flange, pad and pretension)"


def document(answer: "Answer", checker: "Checker", limits: "Limits", alone: bool) -> dict[str, Any]:
    """One verdict for programs; with the highest allowed velocity, which takes a search, where it stands alone."""
    from acf_jax.safety.assumptions import STATEMENT

    a, s = answer, answer.situation
    highest = checker.highest_speed(s) if alone and a.force_limit is not None else None
    return {
        "schema": "acf-check/1",
        "situation": s.name or None,
        "verdict": a.verdict,
        "pressure_verdict": a.pressure_verdict or NO_AREA,
        "reasons": list(a.reasons),
        "cautions": list(a.cautions),
        "body_region": a.area.region,
        "body_area": a.area.name,
        "contact": s.contact,
        "contact_velocity_m_per_s": s.v_e,
        "pretension_n": s.f_p,
        "confidence": checker.confidence,
        "peak_force_n": a.force,
        "peak_force_not_exceeded_n": a.upper,
        "force_limit_n": a.force_limit,
        "pressure_not_exceeded_n_cm2": a.pressure,
        "pressure_limit_n_cm2": a.pressure_limit,
        "highest_allowed_velocity_m_per_s": highest.v if highest else None,
        "highest_allowed_velocity_ended_by": highest.ended_by if highest else None,
        "standard_v_max_m_per_s": a.standard_speed,
        **{column: _finite(float(getattr(s.ending, name))) for name, column in OF_ENDING.items()},
        "lasting_force_n": a.lasting,
        "must_stop_within_s": _finite(a.stop_by),
        "must_stop_within_m": _finite(None if a.stop_by is None else a.stop_by * s.v_e),
        "decided_by": a.decided_by,
        "limits": limits.source,
        "model": checker.model.source,
        "assumptions": _assumptions(a, checker),
        "statement": STATEMENT,
    }


def _finite(value: float | None) -> float | None:
    """JSON knows no infinity."""
    return None if value is None or math.isinf(value) else float(value)


def _assumptions(a: "Answer", checker: "Checker") -> list[str]:
    from acf_jax.safety.assumptions import assumptions

    return (
        assumptions(checker.model, a.situation, a.area, checker.confidence)
        if a.force_limit is not None
        else []
    )


def table(situations: Path, answers: Sequence["Answer"]) -> str:
    """The situations' own columns, row by row, with the verdicts behind them, in place of those of an earlier check."""
    by_line = {a.situation.row: a for a in answers}
    records = records_of(situations, io.StringIO(read_text(situations)))
    header = next(cells for _, cells in records if any(cell.strip() for cell in cells))
    while not header[-1].strip():
        header.pop()
    own = [i for i, cell in enumerate(header) if cell.strip() not in OF_VERDICT]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*(header[i].strip() for i in own), *OF_VERDICT])
    for line, cells in records:
        if (answer := by_line.get(line)) is not None:
            writer.writerow([*(cells[i].strip() for i in own), *_cells(answer)])
    return out.getvalue()


def _cells(a: "Answer") -> list[str]:
    stop_by = _finite(a.stop_by)
    travel = None if stop_by is None else stop_by * a.situation.v_e
    forces = (a.force, a.upper, a.lasting, a.force_limit, a.pressure, a.pressure_limit)
    stops = (a.standard_speed, stop_by, travel)
    return [
        a.area.name,
        a.verdict,
        "; ".join(a.reasons),
        *("" if x is None else f"{x:.6g}" for x in forces),
        a.pressure_verdict or NO_AREA,
        *("" if x is None else f"{x:.4g}" for x in stops),
        a.decided_by,
        "; ".join(a.cautions),
    ]


def summary(out: Path, answers: Sequence["Answer"], checker: "Checker", limits: "Limits") -> str:
    """How a table of situations came out, the first row with each verdict but 'allowed', and what all rows rest on."""
    from acf_jax.safety.assumptions import STATEMENT

    counts = {v: sum(a.verdict == v for a in answers) for v in ("allowed", "not allowed", "not decidable")}
    lines = [f"{len(answers)} situations: " + ", ".join(f"{n} {v}" for v, n in counts.items())]
    for verdict in ("not allowed", "not decidable"):
        if first := next((a for a in answers if a.verdict == verdict), None):
            s = first.situation
            lines.append(
                f"first that is {verdict}: row {s.row}, '{s.name}', {first.area.name}: {first.reasons[0]}"
            )
    asked = [a for a in answers if a.force_limit is not None]
    without_limit = sum(a.pressure_limit is None for a in asked)
    without_area = sum(a.situation.contact_area is None for a in asked if a.pressure_limit is not None)
    if without_area:
        lines.append(f"pressure is not decided in {without_area} of them: no contact area is given")
    if without_limit:
        lines.append(f"pressure is not decided in {without_limit} of them: the limits name none")
    for caution in dict.fromkeys(caution for a in asked for caution in a.cautions):
        lines.append(f"caution: {caution}")
    rows = [_assumptions(a, checker) for a in asked]
    if rows:
        lines.append("All rows take for granted that")
        lines += [f"  - {line}" for line in rows[0] if all(line in row for row in rows)]
        lines.append("and each what --json lists with it")
    return "\n".join([*lines, f"{out}: every verdict, by the limits of {limits.source}", STATEMENT])

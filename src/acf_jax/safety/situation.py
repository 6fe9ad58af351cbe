"""One contact of robot and person, and a table of them."""

import math
from itertools import takewhile
from pathlib import Path
from typing import Literal, NamedTuple

from acf_jax.contact.ending import OPEN, Ending, ending_faults
from acf_jax.dataset.table import Row, Table, read_table
from acf_jax.dataset.units import LEAST_PRETENSION, VELOCITY, Limit
from acf_jax.errors import InputError, shown, suggestion
from acf_jax.safety.limits import BodyArea, Limits

Contact = Literal["transient", "quasi_static"]
CONTACTS: tuple[Contact, ...] = ("transient", "quasi_static")
REQUIRED = ("situation", "body_area", "contact", "contact_velocity_m_per_s", "pretension_n")
OF_ENDING = {
    "stop_after": "stop_after_s",
    "travel": "travel_m",
    "reaction": "reaction_s",
    "deceleration": "deceleration_m_per_s2",
}
MEASURES = ("contact_area_cm2", "robot_mass_kg", "payload_kg")
OPTIONAL = (*MEASURES, *OF_ENDING.values())
STEMS = (
    "contact_area",
    "robot_mass",
    "payload",
    *OF_ENDING,
)  # of optional columns; what begins so is meant as one
OF_VERDICT = (
    "decided_body_area",
    "verdict",
    "reason",
    "peak_force_n",
    "peak_force_not_exceeded_n",
    "lasting_force_n",
    "force_limit_n",
    "pressure_not_exceeded_n_cm2",
    "pressure_limit_n_cm2",
    "pressure_verdict",
    "standard_v_max_m_per_s",
    "must_stop_within_s",
    "must_stop_within_m",
    "decided_by",
    "cautions",
)  # columns that an earlier check has added
CONFIDENCE = (0.5, 0.9999)  # that can be asked for
# zero is as good a velocity, pretension or payload as any: nothing moves, presses or is carried
LIMITS = {
    "v_e": VELOCITY,
    "f_p": Limit("N", LEAST_PRETENSION, 5e3, "if it is in kN, multiply by 1000", "if it is in mN, divide by 1000"),
    "contact_area": Limit("cm^2", 1e-3, 100.0, "if it is in m^2, multiply by 1e4", "if it is in mm^2, divide by 100"),
    "moving_mass": Limit("kg", 0.1, 5e3, "if it is in tonnes, multiply by 1000", "if it is in g, divide by 1000"),
    "payload": Limit("kg", 1e-3, 5e3, "if it is in tonnes, multiply by 1000", "if it is in g, divide by 1000"),
}  # fmt: skip
MAY_BE_ZERO = ("v_e", "f_p", "payload")


class Situation(NamedTuple):
    """What meets what, and how fast."""

    name: str
    areas: tuple[BodyArea, ...]  # what the named part of the body can mean: the verdict holds for each
    contact: Contact  # transient: the body can recoil; quasi-static: it is clamped
    v_e: float  # m/s
    f_p: float  # N
    contact_area: float | None = None  # cm^2
    moving_mass: float | None = None  # kg, M of the standard's formula: the robot's moving parts
    payload: float | None = None  # kg, m_L
    row: int = 0  # of the file it comes from
    ending: Ending = OPEN  # how the contact ends


def quantity_fault(quantity: str, value: float | None) -> str | None:
    """Why a number of a situation cannot be right, with the remedy; None where it can, or is not given."""
    limit = LIMITS[quantity]
    if value is None or (value == 0 and quantity in MAY_BE_ZERO) or limit.low <= value <= limit.high:
        return None
    if math.isfinite(value) and value <= 0:
        least = "zero or positive" if quantity in MAY_BE_ZERO else "positive"
        return f"must be {least}, in {limit.unit}, but is {value:g}"
    return limit.fault(value)


def situation_faults(s: Situation) -> list[str]:
    """What is wrong with a situation made in a program; nothing of one that was read."""
    faults = [
        f"{quantity} {fault}"
        for quantity in LIMITS
        if (fault := quantity_fault(quantity, getattr(s, quantity))) is not None
    ]
    if s.contact not in CONTACTS:
        faults.append(f"contact is {shown(s.contact)}; write {' or '.join(CONTACTS)}")
    if (s.moving_mass is None) != (s.payload is None):
        faults.append("moving_mass and payload belong together; give both or neither")
    faults += [f"ending.{fault}" for fault in ending_faults(s.ending)]
    if not s.areas:
        faults.append("areas is empty; take them from Limits.find")
    return faults


def read_situations(path: Path, limits: Limits) -> tuple[Situation, ...]:
    """The situations of a CSV file; `InputError` lists every fault."""
    table = read_table(path, REQUIRED)
    for column in table.columns:
        if column not in (*REQUIRED, *OPTIONAL, *OF_VERDICT) and (hint := _meant(column)):
            table.fault("", f"column {shown(column)} is not known{hint}; correct or rename it")
    rows = takewhile(lambda _: not table.is_hopeless, table.rows)
    found = [s for row in rows if (s := _situation(table, row, limits))]
    if not table.rows and not table.faults:
        table.fault("", "holds no situations; add one row a situation below the first line")
    if table.faults:
        raise InputError(table.shown_faults())
    return tuple(found)


def _meant(column: str) -> str:
    """`; did you mean ...` for a column that looks like an optional one, which must not be missed in silence."""
    stem = next(
        (known for known, stem in zip(OPTIONAL, STEMS, strict=True) if column.lower().startswith(stem)), ""
    )
    return f"; did you mean {shown(stem)}?" if stem else suggestion(column.lower(), OPTIONAL)


def _situation(table: Table, row: Row, limits: Limits) -> Situation | None:
    where, before = f"row {row.number}", len(table.faults)
    if any(column not in row.cells for column in REQUIRED):
        return None
    if not row.cells["situation"]:
        table.fault(where, "situation is empty; name it")
    if row.cells["contact"] not in CONTACTS:
        table.fault(where, f"contact is {shown(row.cells['contact'])}; write {' or '.join(CONTACTS)}")
    areas: tuple[BodyArea, ...] = ()
    try:
        areas = limits.find(row.cells["body_area"])
    except InputError as error:
        table.fault(where, error.faults[0])
    columns = (*REQUIRED[3:], *MEASURES)
    given = [_optional(table, row, column) for column in columns]
    for quantity, column, value in zip(LIMITS, columns, given, strict=True):
        if (fault := quantity_fault(quantity, value)) is not None:
            table.fault(where, f"{column} {fault}; correct it{' or leave it empty' * (column in OPTIONAL)}")
    told = {name: _optional(table, row, column) for name, column in OF_ENDING.items()}
    ending = Ending(**{name: math.inf if value is None else value for name, value in told.items()})
    for fault in ending_faults(ending, OF_ENDING):
        table.fault(where, f"{fault}, or leave it empty")
    if bool(row.cells.get("robot_mass_kg")) != bool(row.cells.get("payload_kg")):
        table.fault(where, "robot_mass_kg and payload_kg belong together; give both or neither")
    if len(table.faults) > before:
        return None
    contact: Contact = "transient" if row.cells["contact"] == "transient" else "quasi_static"
    v_e, f_p, area, moving_mass, payload = given
    name = row.cells["situation"]
    return Situation(
        name, areas, contact, v_e or 0.0, f_p or 0.0, area, moving_mass, payload, row.number, ending
    )


def _optional(table: Table, row: Row, column: str) -> float | None:
    """The number of a cell, which may be empty, or its column missing, where it is an optional one."""
    return None if column in OPTIONAL and not row.cells.get(column) else table.number(row, column)

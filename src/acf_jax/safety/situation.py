"""One contact of robot and person, and a table of them."""

from pathlib import Path
from typing import Literal, NamedTuple

from acf_jax.dataset.table import Row, Table, read_table
from acf_jax.errors import InputError, shown
from acf_jax.safety.limits import BodyArea, Limits

Contact = Literal["transient", "quasi_static"]
CONTACTS: tuple[Contact, ...] = ("transient", "quasi_static")
REQUIRED = ("situation", "body_area", "contact", "contact_velocity_m_per_s", "pretension_n")
OPTIONAL = ("contact_area_cm2", "robot_mass_kg", "payload_kg")


class Situation(NamedTuple):
    """What meets what, and how fast."""

    name: str
    area: BodyArea
    contact: Contact  # transient: the body can recoil; quasi-static: it is clamped
    v_e: float  # m/s
    f_p: float  # N
    contact_area: float | None = None  # cm^2
    moving_mass: float | None = None  # kg, M of the standard's formula: the robot's moving parts
    payload: float | None = None  # kg, m_L
    row: int = 0  # of the file it comes from


def read_situations(path: Path, limits: Limits) -> tuple[Situation, ...]:
    """The situations of a CSV file; `InputError` lists every fault."""
    table = read_table(path, REQUIRED)
    found = [s for row in table.rows if (s := _situation(table, row, limits))]
    if not table.rows and not table.faults:
        table.fault("", "holds no situations; add one row a situation below the first line")
    if table.faults:
        raise InputError(table.shown_faults())
    return tuple(found)


def _situation(table: Table, row: Row, limits: Limits) -> Situation | None:
    where, before = f"row {row.number}", len(table.faults)
    if any(column not in row.cells for column in REQUIRED):
        return None
    if row.cells["contact"] not in CONTACTS:
        table.fault(where, f"contact is {shown(row.cells['contact'])}; write {' or '.join(CONTACTS)}")
    area = None
    try:
        area = limits.find(row.cells["body_area"])
    except InputError as error:
        table.fault(where, error.faults[0])
    numbers = [table.number(row, column) for column in REQUIRED[3:]]
    for column, value in zip(REQUIRED[3:], numbers, strict=True):
        if value is not None and value < 0:
            table.fault(where, f"{column} must be zero or positive, but is {value:g}; correct it")
    given = [table.number(row, column) if row.cells.get(column) else None for column in OPTIONAL]
    for column, value in zip(OPTIONAL, given, strict=True):
        if value is not None and (value < 0 or (value == 0 and column != "payload_kg")):
            table.fault(where, f"{column} must be positive, but is {value:g}; correct it or leave it empty")
    if len(table.faults) > before or area is None:
        return None
    v_e, f_p = (float(value or 0.0) for value in numbers)
    contact: Contact = "transient" if row.cells["contact"] == "transient" else "quasi_static"
    contact_area, moving_mass, payload = given
    name = row.cells["situation"]
    return Situation(name, area, contact, v_e, f_p, contact_area, moving_mass, payload, row.number)

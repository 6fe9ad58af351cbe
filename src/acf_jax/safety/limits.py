"""Biomechanical limits per body area: ISO/TS 15066:2016, Table A.2 and A.3, or a user's own file of that form."""

import difflib
import re
from pathlib import Path
from typing import NamedTuple

from acf_jax.dataset.table import Row, Table, read_table
from acf_jax.errors import InputError, shown

SHIPPED = Path(__file__).with_name("iso_ts_15066.csv")
TEXT = ("body_region", "specific_location")
POSITIVE = ("quasi_static_force_n", "spring_constant_n_mm", "effective_mass_kg")
OPTIONAL = ("quasi_static_pressure_n_cm2", "transient_force_factor", "transient_pressure_factor")
NEVER = re.compile(r"\b(head|skull|forehead|temple|face|jaw|eye|eyes)\b", re.IGNORECASE)


class BodyArea(NamedTuple):
    """Limits and mechanics of one area of the body."""

    region: str
    name: str
    number: str  # of the standard's table; empty in a user's file without the column
    force: float  # N, quasi-static
    pressure: float | None  # N/cm^2, quasi-static
    force_factor: float | None  # transient limit over quasi-static; None: contact is not permissible
    pressure_factor: float | None
    stiffness: float  # N/m
    mass: float  # kg, effective

    @property
    def is_permissible(self) -> bool:
        """Contact with head or face never is, whatever a file says."""
        return self.force_factor is not None and not NEVER.search(f"{self.region} {self.name}")


class Limits(NamedTuple):
    """The areas of one file."""

    source: str
    areas: tuple[BodyArea, ...]

    def find(self, name: str) -> BodyArea:
        """The area of that number or name; a name that means several means the strictest of them.

        **Raises:** `InputError` that names what there is.
        """
        wanted = name.strip().lower()
        by_number = [a for a in self.areas if a.number and a.number == wanted]
        exact = [a for a in self.areas if a.name.lower() == wanted]
        begins = [a for a in self.areas if wanted and a.name.lower().startswith(wanted)]
        region = [a for a in self.areas if a.region.lower() == wanted]
        for found in (by_number, exact, begins, region):
            if found:
                return min(found, key=lambda a: (a.is_permissible, a.force, a.pressure or 0.0))
        names = [a.name for a in self.areas]
        words = {
            n.lower(): n for n in (*names, *(a.region for a in self.areas), *(n.split()[0] for n in names))
        }
        close = difflib.get_close_matches(wanted, words, n=1, cutoff=0.6)
        hint = f"did you mean '{words[close[0]]}'?" if close else f"known are {', '.join(names)}"
        raise InputError(f"body area {shown(name)} is not in {self.source}; {hint}")


def read_limits(path: Path | None = None) -> Limits:
    """The limits in a CSV file; without a path those of ISO/TS 15066.

    **Raises:** `InputError` with every fault of the file.
    """
    table = read_table(path or SHIPPED, (*TEXT, *POSITIVE, *OPTIONAL))
    areas = [area for row in table.rows if (area := _area(table, row))] if not table.faults else []
    for name in {a.name.lower() for a in areas}:
        same = [a for a in areas if a.name.lower() == name]
        if len(same) > 1:
            table.fault("", f"body area '{same[0].name}' is there {len(same)} times; give each its own name")
    if not areas and not table.faults:
        table.fault("", "holds no body areas; add one row an area")
    if table.faults:
        raise InputError(table.shown_faults())
    return Limits("ISO/TS 15066:2016" if path is None else str(path), tuple(areas))


def _area(table: Table, row: Row) -> BodyArea | None:
    values: dict[str, float | None] = {}
    before = len(table.faults)
    for column in TEXT:
        if not row.cells[column]:
            table.fault(f"row {row.number}", f"{column} is empty; name it")
    for column in (*POSITIVE, *OPTIONAL):
        is_absent = column in OPTIONAL and not row.cells[column]
        value = values[column] = None if is_absent else table.number(row, column)
        if value is not None and value <= 0:
            table.fault(f"row {row.number}", f"{column} must be positive, but is {value:g}; correct it")
    if len(table.faults) > before:
        return None
    force, spring, mass = (float(values[column] or 0.0) for column in POSITIVE)
    pressure, force_factor, pressure_factor = (values[column] for column in OPTIONAL)
    return BodyArea(
        row.cells["body_region"],
        row.cells["specific_location"],
        row.cells.get("area_number", ""),
        force,
        pressure,
        force_factor,
        pressure_factor,
        1e3 * spring,
        mass,
    )

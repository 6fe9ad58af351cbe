"""Biomechanical limits per body area: ISO/TS 15066:2016, Table A.2 and A.3, or a user's own file of that form."""

import difflib
import functools
import unicodedata
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from acf_jax.contact.body import Body
from acf_jax.dataset.table import Row, Table, read_table
from acf_jax.dataset.units import Limit
from acf_jax.errors import InputError, shown

SHIPPED = Path(__file__).with_name("iso_ts_15066.csv")
STANDARD = "ISO/TS 15066:2016"
SOURCE = f"{STANDARD} (contents of ISO 10218-2:2025)"
TEXT = ("body_region", "specific_location")
# twice to ten times what the standard's areas span: beyond it a value is in another unit
NEEDED = {
    "quasi_static_force_n": Limit("N", 1.0, 1e3, "if it is in kN, multiply by 1000", "if it is in mN, divide by 1000"),
    "spring_constant_n_mm": Limit("N/mm", 1.0, 1e3, too_high="if it is in N/m, divide by 1000"),
    "effective_mass_kg": Limit("kg", 0.02, 150.0, "if it is in tonnes, multiply by 1000", "if in g, divide by 1000"),
}  # fmt: skip
OPTIONAL = {
    "quasi_static_pressure_n_cm2": Limit("N/cm^2", 1.0, 1e3, too_high="if it is in kPa, divide by 10"),
    "transient_force_factor": Limit("(a factor)", 0.1, 2.0, too_high="the standard's is 2"),
    "transient_pressure_factor": Limit("(a factor)", 0.1, 2.0, too_high="the standard's is 2"),
}
LEAST_LETTERS = 3  # of the beginning of a name


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
    caution: str = ""  # how a user's limits compare with the standard's

    @property
    def is_permissible(self) -> bool:
        """Contact with head or face never is, whatever a file says."""
        return self.force_factor is not None and self.region not in _barred_regions()

    @property
    def transient_force(self) -> float:
        """N; zero where contact is not permissible."""
        return self.force * (self.force_factor or 0.0)

    @property
    def transient_pressure(self) -> float | None:
        """N/cm^2; None where it is not stated."""
        if self.pressure is None or self.pressure_factor is None:
            return None
        return self.pressure * self.pressure_factor


class Limits(NamedTuple):
    """The areas of one file."""

    source: str
    areas: tuple[BodyArea, ...]

    def find(self, name: str) -> tuple[BodyArea, ...]:
        """The areas that a number, a name, a region, or the beginning of one of them can mean.

        The beginning of any word of a region stands for the region: 'arm' could be upper or lower, so it is refused.

        **Returns:** all of them, within one region; a check holds for each.

        **Raises:** `InputError` that names what there is, or what else was meant.
        """
        wanted = " ".join(name.lower().split())
        by_number = [a for a in self.areas if a.number and a.number == wanted]
        exact = [a for a in self.areas if wanted in (a.name.lower(), a.region.lower())]
        begun = [a for a in self.areas if _begins(a, wanted)] if len(wanted) >= LEAST_LETTERS else []
        for found in (by_number, exact, begun):
            regions = dict.fromkeys(a.region for a in found)
            if len(regions) > 1:
                meant = " or ".join(f"'{a.name}' ({a.region})" for a in _one_of_each(found))
                raise InputError(
                    f"body area {shown(name)} can mean {meant}; write the name of the area or of the region out"
                )
            if found:
                return tuple(found)
        names = [a.name for a in self.areas]
        words = {
            n.lower(): n for n in (*names, *(a.region for a in self.areas), *(n.split()[0] for n in names))
        }
        close = difflib.get_close_matches(wanted, words, n=1, cutoff=0.6)
        hint = f"did you mean '{words[close[0]]}'?" if close else f"known are {', '.join(names)}"
        raise InputError(
            f"body area {shown(name)} is not in {self.source}; {hint} (contact with skull, forehead and face, eyes and"
            " ears and teeth included, is never permissible)"
        )


def _begins(area: BodyArea, wanted: str) -> bool:
    region = area.region.lower()
    words = region.split()
    in_region = region.startswith(wanted) or any(word.startswith(wanted) for word in words)
    return in_region or area.name.lower().startswith(wanted)


def _one_of_each(areas: list[BodyArea]) -> list[BodyArea]:
    """The first area of each region."""
    return list({a.region: a for a in reversed(areas)}.values())[::-1]


def read_limits(path: Path | None = None) -> Limits:
    """The limits in a CSV file; without a path those of ISO/TS 15066.

    **Raises:** `InputError` with every fault of the file.
    """
    if path is None:
        return _standard()
    return Limits(str(path), tuple(_compared(area) for area in _read(path)))


@functools.cache
def _standard() -> Limits:
    return Limits(SOURCE, tuple(_read(SHIPPED)))


@functools.cache
def _barred_regions() -> frozenset[str]:
    """Regions of the standard with an area that must not be touched."""
    return frozenset(a.region for a in _standard().areas if a.force_factor is None)


def _region(table: Table, row: Row) -> str:
    """The standard's region of a user's area: head or face where anything of the row says so, else by name or number.

    What an area is called says nothing about where it lies, in whatever language; so an area that is none of the
    standard's has to name its region.
    """
    own, given = (_plain(row.cells[column]) for column in ("specific_location", "body_region"))
    number = row.cells.get("area_number", "").lstrip("0")
    standard = _standard().areas
    meant = [a.region for a in standard if own == _plain(a.name)]
    meant += [a.region for a in standard if number and number == a.number]
    meant += [a.region for a in standard if given == _plain(a.region)]
    if not meant:
        regions = dict.fromkeys(a.region for a in standard)
        table.fault(
            f"row {row.number}",
            f"body_region {shown(row.cells['body_region'])} is no region of {STANDARD}; name the one in which"
            f" {shown(row.cells['specific_location'])} lies: {', '.join(regions)}",
        )
        return ""
    return next((region for region in meant if region in _barred_regions()), meant[0])


def _plain(text: str) -> str:
    return " ".join(unicodedata.normalize("NFKC", text).casefold().split())


def _read(path: Path) -> list[BodyArea]:
    table = read_table(path, (*TEXT, *NEEDED, *OPTIONAL))
    region = _region if path != SHIPPED else lambda _, row: row.cells["body_region"]
    areas = [area for row in table.rows if (area := _area(table, row, region))] if not table.faults else []
    for name in {a.name.lower() for a in areas}:
        same = [a for a in areas if a.name.lower() == name]
        if len(same) > 1:
            table.fault("", f"body area '{same[0].name}' is there {len(same)} times; give each its own name")
    if not areas and not table.faults:
        table.fault("", "holds no body areas; add one row an area")
    if table.faults:
        raise InputError(table.shown_faults())
    return areas


def _area(table: Table, row: Row, region: Callable[[Table, Row], str]) -> BodyArea | None:
    values: dict[str, float | None] = {}
    before = len(table.faults)
    if not row.cells["specific_location"]:
        table.fault(f"row {row.number}", "specific_location is empty; name it")
    for column, limit in (NEEDED | OPTIONAL).items():
        is_absent = column in OPTIONAL and not row.cells[column]
        value = values[column] = None if is_absent else table.number(row, column)
        if value is not None and (fault := limit.fault(value)):
            table.fault(f"row {row.number}", f"{column} {fault}")
    lies_in = region(table, row)
    if len(table.faults) > before:
        return None
    force, spring, mass = (float(values[column] or 0.0) for column in NEEDED)
    pressure, force_factor, pressure_factor = (values[column] for column in OPTIONAL)
    return BodyArea(
        lies_in,
        row.cells["specific_location"],
        row.cells.get("area_number", ""),
        force,
        pressure,
        force_factor,
        pressure_factor,
        1e3 * spring,
        mass,
    )


def _compared(area: BodyArea) -> BodyArea:
    """The area with a caution where it is not the standard's, or above the standard's limits."""
    of_name = [a for a in _standard().areas if a.name.lower() == area.name.lower()]
    if not of_name:
        return area._replace(
            caution=f"'{area.name}' is no area of {STANDARD}: its limits are the user's own, and so is its place in"
            f" {area.region}"
        )
    (own,) = of_name
    rows = (
        ("N clamped", area.force, own.force),
        ("N transient", area.transient_force, own.transient_force),
        ("N/cm^2 clamped", area.pressure, own.pressure),
        ("N/cm^2 transient", area.transient_pressure, own.transient_pressure),
    )
    above = [
        f"{'no limit' if value is None else format(value, 'g')} for {limit:g} {unit}"
        for unit, value, limit in rows
        if limit is not None and (value is None or value > limit)
    ]
    if not above:
        return area
    return area._replace(caution=f"own limits of '{area.name}' are above {STANDARD}: {', '.join(above)}")


def limits_of(area: BodyArea, contact: str) -> tuple[float, float | None]:
    """Force (N) and pressure (N/cm^2) that hold: the factors belong to the limit, never to the force."""
    if contact == "transient":
        return area.transient_force, area.transient_pressure
    return area.force, area.pressure


def body_of(area: BodyArea, contact: str) -> Body:
    """The area's stiffness, and its mass where it can recoil."""
    return Body(1 / area.stiffness, 1 / area.mass if contact == "transient" else 0.0)

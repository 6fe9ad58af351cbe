"""Units that signals come in, and what one of each is in SI units."""

import re
import unicodedata

_FORCE = {"N": 1.0, "kN": 1e3, "mN": 1e-3, "kgf": 9.80665, "gf": 9.80665e-3, "lbf": 4.4482216152605}
UNITS = {  # by what a signal is; the SI unit first
    "force": _FORCE,
    "velocity": {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2, "m/min": 1 / 60, "in/s": 0.0254},
    "position": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "µm": 1e-6, "in": 0.0254},
    "pretension": _FORCE,
}
# Units of what is none of these, so that the unit of a signal cannot be one of them.
_OTHER = ["bar", "mbar", "Pa", "kPa", "MPa", "psi", "V", "mV", "rad", "deg", "°", "rad/s", "deg/s", "°/s"]
_PER_SECOND = re.compile(r"(?:/sec|[ .*·]?s\^?[-−]1)$")


def _folded(unit: str) -> str:
    return _PER_SECOND.sub("/s", unicodedata.normalize("NFKD", unit.strip().casefold()))


_KNOWN = {_folded(unit) for unit in (*_OTHER, *(u for units in UNITS.values() for u in units))}
_FACTORS = {kind: {_folded(unit): x for unit, x in units.items()} for kind, units in UNITS.items()}


def factor(unit: str, kind: str) -> float | None:
    """One `unit` of a force, velocity, position or pretension in SI units; None where it is no unit of that.

    **Raises:** `ValueError` where it is a unit of something else.
    """
    known = _folded(unit)
    found = _FACTORS[kind].get(known)
    if found is None and known in _KNOWN:
        raise ValueError(f"is in {unit}, no unit of a {kind}")
    return found

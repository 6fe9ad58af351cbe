"""A rig from a YAML file or from options, checked, with all faults at once."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from acf_jax.documents import is_number
from acf_jax.errors import InputError, shown
from acf_jax.files import read_yaml_mapping

UNITS = {"m": "kg", "d": "N s/m", "k_f": "N/m", "k_c": "N/m", "v_e": "m/s", "f_p": "N", "limit": "N"}
MUST_BE_POSITIVE = ("m", "k_c", "limit")
RIG = ("m", "d", "k_f", "k_c")


def value_fault(name: str, value: Any, where: str) -> str | None:
    """What is wrong with a parameter's value, its sign or its unit, or None."""
    from acf_jax.dataset.units import unit_fault

    range_ = "positive" if name in MUST_BE_POSITIVE else "zero or positive"
    if is_number(value) and (value > 0 or (value == 0 and name not in MUST_BE_POSITIVE)):
        return f"{where} {fault}" if (fault := unit_fault(name, value)) else None
    return (
        f"{where} must be a number, finite and {range_}, in {UNITS[name]}, but is {shown(value)}; correct it"
    )


def read_rig(path: Path) -> tuple[dict[str, float], list[str]]:
    """The four parameters below the key `rig` of a YAML file, and the faults found."""
    try:
        rig = read_yaml_mapping(path).get("rig")
    except InputError as error:
        return {}, error.faults
    remedy = "write `rig:` with m, d, k_f and k_c below it, in SI units"
    if not isinstance(rig, Mapping):
        return {}, [f"{path}: key 'rig' is missing or holds no keys; {remedy}"]
    faults = [f"{path} rig.{name}: is missing; {remedy}" for name in RIG if name not in rig]
    faults += [f"{path} rig.{name}: is not known; {remedy}" for name in rig if name not in RIG]
    faults += _faults((name, rig[name], f"{path} rig.{name}:") for name in RIG if name in rig)
    return {name: rig[name] for name in RIG if name in rig}, faults


def collect_rig(path: Path | None, options: Mapping[str, float | None]) -> tuple[dict[str, float], list[str]]:
    """The rig of the file, with the options given beside it in place of the file's values."""
    rig, faults = read_rig(path) if path else ({}, [])
    given = {name: value for name, value in options.items() if value is not None}
    faults += _faults((name, value, option(name)) for name, value in given.items())
    rig |= given
    if path is None:
        missing = [option(name) for name in RIG if name not in rig]
        faults += [f"{name} is missing; give it, or all four by --rig FILE" for name in missing]
    return rig, faults


def option(name: str) -> str:
    """The command line's option of a parameter."""
    return "--" + name.replace("_", "-")


def _faults(values: Iterable[tuple[str, Any, str]]) -> list[str]:
    return [fault for value in values if (fault := value_fault(*value))]

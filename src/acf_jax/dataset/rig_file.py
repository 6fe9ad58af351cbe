"""A rig's file, the same for every command: each parameter with its value and, where it is known, its deviation.

    rig:
      m: 4.0                                # or
      m: {value: 4.0, std: 0.1, unit: kg}   # or
      moving_mass_kg: {value: 4.0, std: 0.1}
    relative_std: {m: 0.02, v_e: 0.005}     # standard deviation over value, in place of `std`
    tried: {v_e: [0.05, 0.35], f_p: [50, 90]}

A data set's dataset.yaml is such a file, too.
"""

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from acf_jax.dataset.units import QUANTITIES, RELATIVE_STD, unit_fault, value_fault
from acf_jax.documents import is_number
from acf_jax.errors import InputError, shown, suggestion
from acf_jax.files import read_yaml_mapping

RIG = ("m", "d", "k_f", "k_c")
IMPACT = ("v_e", "f_p")
LONG = ("moving_mass_kg", "damping_n_s_per_m", "actuator_stiffness_n_per_m", "contact_stiffness_n_per_m")
KEYS = dict(zip(RIG, LONG, strict=True))  # the paper's symbols, and the names that carry their units
NAMES = {key: name for name, key in KEYS.items()} | {name: name for name in RIG}
BESIDE = ("schema", "description", "measurement", "relative_std", "tried")  # keys beside `rig`
SPREAD = {"v_e": "contact_velocity_rel_std", "f_p": "pretension_rel_std"}  # of `measurement`
PART = ("value", "std", "unit")
REMEDY = "write `rig:` with m, d, k_f and k_c below it, in SI units"


@dataclass(frozen=True)
class Rig:
    """What a rig's file says to a command that needs values."""

    values: dict[str, float]  # of m, d, k_f, k_c, SI units
    stds: dict[str, float] = field(default_factory=dict)  # in the unit of the value, of those that have one
    relative_std: dict[str, float] = field(default_factory=dict)  # over the value, of v_e and f_p as well
    tried: tuple[tuple[float, float], tuple[float, float]] | None = None  # of v_e and of f_p


def read_rig(path: Path) -> tuple[dict[str, float], list[str]]:
    """The values of the four parameters in a rig's file, and the faults found."""
    rig, faults = read_whole_rig(path)
    return rig.values, faults


def read_whole_rig(path: Path) -> tuple[Rig, list[str]]:
    """All of a rig's file but for what only a data set needs, and the faults found."""
    try:
        content = read_yaml_mapping(path)
    except InputError as error:
        return Rig({}), error.faults
    parts, faults = _parts(content, str(path))
    known = ("rig", *BESIDE)
    faults += [
        f"{path} {key}: belongs below `rig:`"
        if key in NAMES
        else f"{path} {key}: is not known{suggestion(key, known)}; use rig, relative_std and tried"
        for key in content
        if key not in known
    ]
    values, stds = {}, {}
    for name, part in parts.items():
        where = f"{path} rig.{part.key}:"
        if fault := value_fault(name, part.value, where):
            faults.append(fault)
        else:
            values[name] = part.value
        if part.std is not None:
            if not is_number(part.std) or part.std <= 0:
                faults.append(f"{where} std must be a number above 0, but is {shown(part.std)}; correct it")
            else:
                stds[name] = part.std
    shares, wrong = _shares(content.get("relative_std"), str(path))
    tried, of_tried = _tried(content.get("tried"), str(path))
    measured = content.get("measurement")
    given: dict[str, Any] = measured if isinstance(measured, dict) else {}
    stated = {name: given[key] for name, key in SPREAD.items() if key in given}
    shares = {name: x for name, x in stated.items() if is_number(x) and 0 <= x <= 0.5} | shares
    return Rig(values, stds, shares, tried), [*faults, *wrong, *of_tried]


def as_prior(content: dict[str, Any], where: str) -> tuple[dict[str, Any], dict[str, str], list[str]]:
    """The content of a rig's file in the form of a dataset.yaml, whose check tells what else is wrong.

    **Returns:** the content; by the key there, what the user calls it; the faults that the form cannot see.
    """
    if not isinstance(content.get("rig"), Mapping):
        return content, {}, []
    parts, faults = _parts(content, where, needs_all=False)
    shares, wrong = _shares(content.get("relative_std"), where)
    _, of_tried = _tried(content.get("tried"), where)
    rig: dict[str, Any] = {}
    for key, given in _respelt(content["rig"])[0].items():
        name = NAMES.get(key)
        part = parts.get(name) if name else None
        if name is None or part is None or part.key != key:
            rig |= {} if name else {key: given}  # unknown: the form says so
            continue
        std = part.std
        if std is None and name in shares and is_number(part.value):
            std = shares[name] * part.value
        if std is None and is_number(given):
            what = f"write {key}: {{value: {given:g}, std: ...}}"
            faults.append(f"{where}: rig.{key}: has no standard deviation, which a diagnosis needs; {what}")
            std = 1.0  # no second fault
        whole = (
            {k: v for k, v in given.items() if k != "unit"}
            if isinstance(given, Mapping)
            else {"value": given}
        )
        known = whole if std is None else whole | {"std": std}
        rig[KEYS[name]] = known if isinstance(given, Mapping) or is_number(given) else given
    rest = {key: value for key, value in content.items() if key not in ("rig", "relative_std", "tried")}
    spread = {}
    for name in [name for name in SPREAD if name in shares]:
        if fault := RELATIVE_STD.fault(shares[name]):
            wrong.append(f"{where} relative_std.{name}: {fault}")
        else:
            spread[SPREAD[name]] = shares[name]
    measured = content.get("measurement", {})
    if spread and isinstance(measured, Mapping):
        rest["measurement"] = spread | dict(measured)
    called = {KEYS[name]: part.key for name, part in parts.items()}
    return {**rest, "rig": rig}, called, [*faults, *wrong, *of_tried]


@dataclass(frozen=True)
class _Part:
    """One parameter as it is written."""

    key: str
    value: Any
    std: Any


def _parts(
    content: Mapping[str, Any], where: str, needs_all: bool = True
) -> tuple[dict[str, _Part], list[str]]:
    """The parameters by the paper's symbol; `needs_all`: one that is missing or not known is a fault."""
    rig = content.get("rig")
    if not isinstance(rig, Mapping):
        return {}, [f"{where}: key 'rig' is missing or holds no keys; {REMEDY}"]
    shares = content.get("relative_std")
    parts: dict[str, _Part] = {}
    rig, meant = _respelt(rig)
    faults = [
        f"{where}{'' if needs_all else ':'} rig.{key}: is not known; did you mean {shown(name)}?"
        for key, name in meant.items()
    ]
    for key, given in rig.items():
        name = NAMES.get(key)
        at = f"{where} rig.{key}:" if needs_all else f"{where}: rig.{key}:"
        if name is None:
            faults += [f"{at} is not known; {REMEDY}"] if needs_all else []
        elif name in parts:
            faults.append(f"{at} says what {parts[name].key} says; keep one of the two")
        else:
            whole = given if isinstance(given, Mapping) else {"value": given}
            parts[name] = _Part(key, whole.get("value"), whole.get("std"))
            unit = QUANTITIES[name].unit
            if whole.get("unit", unit) != unit:
                faults.append(f"{at} unit must be {unit}, but is {shown(whole['unit'])}; convert the value")
            if needs_all:
                strange = [inner for inner in whole if inner not in PART]
                faults += [f"{at} {inner}: is not known; use value, std and unit" for inner in strange]
            if isinstance(shares, Mapping) and name in shares and "std" in whole:
                faults.append(f"{at} std and relative_std.{name} both say how well it is known; keep one")
    missing = [name for name in RIG if name not in parts] if needs_all else []
    return parts, [*(f"{where} rig.{name}: is missing; {REMEDY}" for name in missing), *faults]


def _respelt(rig: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    """The rig with its misspelt parameters as they are meant, so that each is one fault; and what each key means.

    A key is misspelt where it resembles that of a parameter which the rig lacks.
    """
    lacks = [key for key in NAMES if not {NAMES[key], KEYS[NAMES[key]]} & set(rig)]
    meant: dict[str, str] = {}
    for key in rig:
        if key not in NAMES and (close := difflib.get_close_matches(str(key), lacks, n=1)):
            meant[key] = close[0]
            lacks = [other for other in lacks if NAMES[other] != NAMES[close[0]]]
    return {meant.get(key, key): given for key, given in rig.items()}, meant


def _shares(given: Any, where: str) -> tuple[dict[str, float], list[str]]:
    """`relative_std`, and what is wrong with it."""
    if given is None:
        return {}, []
    if not isinstance(given, Mapping):
        return {}, [f"{where} relative_std: must hold `name: share` pairs; correct it"]
    faults = {}
    for name, value in given.items():
        if name not in (*RIG, *IMPACT):
            faults[name] = f"is not known; use {', '.join((*RIG, *IMPACT))}"
        elif not is_number(value) or not 0 <= value <= 0.5:
            faults[name] = f"must be a share from 0 to 0.5, but is {shown(value)}; correct it"
    sound = {name: float(value) for name, value in given.items() if name not in faults}
    return sound, [f"{where} relative_std.{name}: {fault}" for name, fault in faults.items()]


def _tried(
    given: Any, where: str
) -> tuple[tuple[tuple[float, float], tuple[float, float]] | None, list[str]]:
    """`tried`, and what is wrong with it."""
    if given is None:
        return None, []
    remedy = "write tried: {v_e: [low, high], f_p: [low, high]}"
    if not isinstance(given, Mapping) or set(given) != set(IMPACT):
        return None, [f"{where} tried: must name v_e and f_p; {remedy}"]
    faults = []
    for name in IMPACT:
        if not _is_range(given[name]):
            faults.append(f"{where} tried.{name}: must be two numbers, the lower first; {remedy}")
        elif fault := unit_fault(name, given[name][1]):
            faults.append(f"{where} tried.{name}: {fault}")
    if faults:
        return None, faults
    (v_low, v_high), (f_low, f_high) = (given[name] for name in IMPACT)
    return ((float(v_low), float(v_high)), (float(f_low), float(f_high))), []


def _is_range(value: Any) -> bool:
    numbers = isinstance(value, list) and len(value) == 2 and all(is_number(x) for x in value)
    return numbers and 0 <= value[0] < value[1]

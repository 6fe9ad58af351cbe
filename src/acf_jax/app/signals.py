"""The signals of a recording as a form: from mapping.yaml to what the page shows, and back."""

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from acf_jax.documents import yaml_text
from acf_jax.errors import InputError, shown
from acf_jax.files import read_yaml_mapping, write_text
from acf_jax.si import UNITS

ROLES = ("force", "speed", "pretension")
AUTO = ""  # nothing is named: the only candidate is taken
_REMEDY = re.compile(r"put (?P<factor>-?[\d.]+(?:e[-+]?\d+)?)\* before its name")


class Chosen(NamedTuple):
    """What mapping.yaml says of one role."""

    key: str  # force, velocity, position or pretension
    signal: dict[str, Any] | None  # with its name; None: not named
    number: float | None  # in place of a signal
    scale: float

    @property
    def value(self) -> str:
        """As the choice of the page has it."""
        if self.signal is None:
            return AUTO
        return value_of(str(self.signal["name"]), self.signal.get("field"))

    @property
    def unit(self) -> str:
        """The unit that the size of the factor stands for; the factor itself where it is none."""
        size = abs(self.scale)
        units = UNITS[self.key].items()
        return next((name for name, factor in units if abs(size / factor - 1) < 1e-6), f"{size!r}")


def value_of(name: str, field: str | None) -> str:
    """A signal as text, which no name can be mistaken in."""
    return json.dumps([name, field])


def read(path: Path) -> dict[str, Any]:
    """The content of mapping.yaml, checked; empty where there is none."""
    from acf_jax.recording import read_mapping

    if not path.exists():
        return {}
    read_mapping(path, {})
    return read_yaml_mapping(path)


def chosen(content: Mapping[str, Any], role: str) -> Chosen:
    """What a mapping says of a role."""
    from acf_jax.recording.mapping import Source, parse_source

    key = "position" if role == "speed" and content.get("position") is not None else _key(role)
    given = content.get(key)
    if isinstance(given, int | float):
        return Chosen(key, None, float(given), 1.0)
    if isinstance(given, str):
        try:
            return Chosen(key, None, float(given), 1.0)
        except ValueError:
            given = parse_source(given).model_dump(exclude_defaults=True)
    if given is None:
        return Chosen(key, None, None, 1.0)
    return Chosen(key, dict(given), None, Source.model_validate(given).scale)


def mapped(before: Mapping[str, Any], fields: Mapping[str, str]) -> dict[str, Any]:
    """The mapping that the page's form says; what else mapping.yaml says stays.

    **Raises:** `InputError` that lists what is wrong with the form.
    """
    content = {key: value for key, value in before.items() if key not in ("velocity", "position")}
    faults: list[str] = []
    for role in ROLES:
        key = fields.get("speed-kind", "velocity") if role == "speed" else role
        if key not in UNITS:
            raise InputError(f"speed: {shown(key)} is neither velocity nor position; choose one")
        given = _one(before, role, key, fields, faults)
        content.pop(key, None)
        if given is not None:
            content[key] = given
    time, rate = fields.get("time", ""), _number("rate", fields.get("rate", ""), faults)
    content = {key: value for key, value in content.items() if key not in ("time", "sample_rate_hz")}
    if time:
        content["time"] = time
    elif rate is not None:
        content["sample_rate_hz"] = rate
    contacts = {key: value for key, value in (before.get("contacts") or {}).items() if key != "tare"}
    if not fields.get("tare"):
        contacts["tare"] = False  # by default `import` takes it off
    content.pop("contacts", None)
    if contacts:
        content["contacts"] = contacts
    if faults:
        raise InputError(faults)
    return content


def text_of(content: Mapping[str, Any]) -> str:
    """mapping.yaml; `InputError` where a command would not take it."""
    from tempfile import TemporaryDirectory

    from acf_jax.recording import read_mapping

    text = yaml_text(dict(content)) if content else "{}\n"
    with TemporaryDirectory() as folder:
        path = Path(folder) / "mapping.yaml"
        write_text(path, text)
        try:
            read_mapping(path, {})
        except InputError as error:
            raise InputError([fault.replace(f"{path}: ", "") for fault in error.faults]) from None
    return text


class Remedy(NamedTuple):
    """A factor that a message names, for one role."""

    role: str
    factor: float
    fault: str


def remedies(faults: Sequence[str], content: Mapping[str, Any], offered: Mapping[str, Any]) -> list[Remedy]:
    """What can be put right by one click: the factors that messages name, by the signal that they are about."""
    found = []
    for fault in faults:
        factors = {match["factor"] for match in _REMEDY.finditer(fault)}
        roles = [role for role in ROLES if (name := _name(content, role, offered)) and _names(fault, name)]
        if len(factors) == 1 and len(roles) == 1:
            found.append(Remedy(roles[0], float(factors.pop()), fault))
    return found


def rescaled(
    content: Mapping[str, Any], offered: Mapping[str, Any], role: str, factor: float
) -> dict[str, Any]:
    """The mapping with another factor before a signal."""
    was = chosen(content, role)
    key, signal = was.key, was.signal
    if signal is None:
        one = _candidate(offered, role)
        if one is None:
            raise InputError(f"{role}: no signal is named; choose one first")
        key = "position" if one.get("is_position") and role == "speed" else key
        signal = {"name": one["name"]} | ({"field": one["field"]} if one.get("field") else {})
    return dict(content) | {key: signal | {"scale": factor}}


def _one(
    before: Mapping[str, Any], role: str, key: str, fields: Mapping[str, str], faults: list[str]
) -> dict[str, Any] | float | None:
    """What the form says of one role."""
    constant = _number(role, fields.get(f"{role}-number", ""), faults)
    value = fields.get(role, AUTO)
    if value == "number":
        if constant is None and not faults:
            faults.append(f"{role}: a number is chosen, but none is given; write it, in N or m/s")
        return constant
    unit = fields.get(f"{role}-unit", "")
    factor = UNITS[key].get(unit) or _number(f"{role} unit", unit or "1", faults) or 1.0
    scale = -factor if fields.get(f"{role}-turned") else factor
    if value == AUTO:
        if scale != 1.0:
            faults.append(f"{role}: name the signal that has this unit or sign")
        return None
    try:
        name, field = json.loads(value)
        is_signal = isinstance(name, str) and isinstance(field, str | None)
    except (TypeError, ValueError):
        is_signal = False
    if not is_signal:
        faults.append(f"{role}: {shown(value)} is no signal of the list; choose one")
        return None
    was = chosen(before, role).signal
    kept = dict(was) if was is not None and was["name"] == name else {"name": name}
    kept = {k: v for k, v in kept.items() if k not in ("field", "scale")}
    return kept | ({"field": field} if field else {}) | ({"scale": scale} if scale != 1.0 else {})


def _number(what: str, text: str, faults: list[str]) -> float | None:
    if not text.strip():
        return None
    try:
        return float(text)
    except ValueError:
        faults.append(f"{what}: {shown(text)} is no number; write digits with a point")
        return None


def _key(role: str) -> str:
    return "velocity" if role == "speed" else role


def _candidate(offered: Mapping[str, Any], role: str) -> dict[str, Any] | None:
    """The only candidate, which is taken where nothing is named."""
    found = (offered.get("candidates") or {}).get(_key(role)) or []
    return found[0] if len(found) == 1 else None


def _names(fault: str, name: str) -> bool:
    """Whether a message names a signal, and no other whose name holds this one."""
    return re.search(rf"(?<![\w/]){re.escape(name)}(?![\w/])", fault) is not None


def _name(content: Mapping[str, Any], role: str, offered: Mapping[str, Any]) -> str | None:
    """The name of a role's signal: as it is named, else that of the only candidate."""
    signal = chosen(content, role).signal or _candidate(offered, role)
    return str(signal["name"]) if signal else None

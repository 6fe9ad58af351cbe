"""Step 3, Rig: what is known beforehand, with units, typical values, and how to measure each."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from starlette.responses import Response

from acf_jax.app.pages.layout import (
    button,
    faults_box,
    form,
    hidden,
    job_panel,
    note,
    number,
    page,
    running,
    select,
)
from acf_jax.app.sessions import DATA, RIG, Session
from acf_jax.dataset.rig_file import KEYS
from acf_jax.documents import yaml_text
from acf_jax.errors import InputError, shown
from acf_jax.files import read_yaml_mapping, write_text
from acf_jax.recording.rig import earlier_rig, read_rig_file
from acf_jax.report.markup import Html, element, formula


class Constant(NamedTuple):
    """One constant of the rig as a user sees it."""

    title: str
    symbol: str
    units: Mapping[str, float]  # to SI
    means: str
    typical: str
    measure: str


CONSTANTS = {
    "m": Constant(
        "Moving mass", "m", {"kg": 1.0, "g": 1e-3},
        "All that moves with the flange: carriage, tool, and half of the bellows.",
        "1 to 10 kg; ± 2 % after weighing.",
        "Weigh the tool and take the flange's moving mass from its data sheet. Weighing hides no hoses: lift them.",
    ),
    "d": Constant(
        "Damping", "d", {"N s/m": 1.0, "N s/mm": 1e3},
        "Resistance of seals, guide and air, by speed.",
        "20 to 200 N s/m; ± 30 % is honest where it was not measured.",
        "Push the free flange, let it swing, and count how fast the amplitude falls: d = 2 m δ / T with the logarithmic"
        " decrement δ and the period T.",
    ),
    "k_f": Constant(
        "Stiffness of the actuator", "k_F", {"N/m": 1.0, "N/mm": 1e3},
        "How much the flange's force rises with its stroke while the pressure control has not acted yet.",
        "0.5 to 10 N/mm; ± 40 % where it was not measured.",
        "Close the valve, press the flange in by some millimetres, and read the force: force over stroke.",
    ),
    "k_c": Constant(
        "Stiffness of the contact", "k_C", {"N/m": 1.0, "N/mm": 1e3},
        "How much the force rises when tool and part are pressed into each other.",
        "50 to 1000 N/mm; ± 10 % after a slow press.",
        "Press slowly against the part with the flange locked, and take the slope of force over travel. A soft pad or a"
        " thin sheet decides it.",
    ),
}  # fmt: skip


class Optional(NamedTuple):
    """What may be stated of the sensor, as a user sees it."""

    key: str  # of `measurement`
    title: str
    label: str
    hint: str


OPTIONAL = {
    "noise": Optional(
        "force_noise_std_n",
        "Noise of the force sensor",
        "Of one sample, N",
        "Standard deviation. Left empty it is taken from the samples before contact.",
    ),
    "tool": Optional(
        "tool_mass_kg",
        "Tool before the sensor",
        "Its mass, kg",
        "Where the sensor sits between flange and tool: all that lies between contact and sensor. Left empty, the"
        " sensor is under the part.",
    ),
}
SHOWN = {"m": "kg", "d": "N s/m", "k_f": "N/mm", "k_c": "N/mm"}  # units of an empty form


def rig(session: Session, faults: Sequence[str] = (), entered: Mapping[str, str] | None = None) -> Response:
    """The page; `entered`: what the user wrote, where it has faults."""
    known: Mapping[str, str] = {}
    found: list[str] = list(faults)
    if entered is None:
        try:
            known = _known(session)
        except InputError as error:
            found += error.faults
    fields = entered if entered is not None else known
    rows = [_constant(name, constant, fields) for name, constant in CONSTANTS.items()]
    sensor = [_optional(name, what, fields) for name, what in OPTIONAL.items()]
    return page(
        "Rig",
        job_panel(session, running(session)),
        faults_box(found),
        element(
            "p",
            "What is known before any trial. A standard deviation that is too small makes the diagnosis blame an effect"
            " for a wrong constant: be honest.",
        ),
        form(
            f"{session.url}/rig",
            hidden("version", session.version(RIG)),
            element("div", *rows, *sensor, class_="beside"),
            button("Save the rig", class_="first", disabled=running(session) is not None),
        ),
        note("Saved as rig.yaml, which every command takes by --rig.") if session.has(RIG) else None,
        session=session,
        step="rig",
        status=400 if faults else 200,
    )


def rig_text(session: Session, fields: Mapping[str, str]) -> str:
    """rig.yaml of what the form says; `InputError` lists what is wrong with it."""
    faults: list[str] = []
    parts: dict[str, dict[str, float]] = {}
    for name, constant in CONSTANTS.items():
        unit = constant.units.get(fields.get(f"{name}-unit", ""))
        if unit is None:
            raise InputError(
                f"{constant.title}: {shown(fields.get(f'{name}-unit', ''))} is no unit of it; choose one"
            )
        pair = {}
        for part, word in (("value", "value"), ("std", "standard deviation")):
            value = _number(fields.get(f"{name}-{part}", ""), f"{constant.title}, {word}", faults)
            if value is not None:
                pair[part] = float(f"{value * unit:.12g}")
        parts[KEYS[name]] = pair
    before = _content(session)
    measurement = _not_asked(before)
    for name, what in OPTIONAL.items():
        if fields.get(name, "").strip():
            value = _number(fields[name], what.title, faults)
            if value is not None:
                measurement[what.key] = value
    if faults:
        raise InputError(faults)
    content = {key: value for key, value in before.items() if key in ("description", "tried")}
    content |= {"rig": parts} | ({"measurement": measurement} if measurement else {})
    text = yaml_text(content)
    with TemporaryDirectory() as folder:
        path = Path(folder) / RIG
        write_text(path, text)
        try:
            read_rig_file(path)
        except InputError as error:
            raise InputError([_named(fault.replace(f"{path}: ", "")) for fault in error.faults]) from None
    return text


def description_with(session: Session, text: str) -> str:
    """dataset.yaml of a data set without a recording, with what `text` says in place of its own."""
    content = read_yaml_mapping(session.folder / DATA / "dataset.yaml")
    with TemporaryDirectory() as folder:
        path = Path(folder) / RIG
        write_text(path, text)
        new = read_yaml_mapping(path)
    measurement = _not_asked(content) | (new.get("measurement") or {})
    content.pop("measurement", None)
    return yaml_text(content | {"rig": new["rig"]} | ({"measurement": measurement} if measurement else {}))


def _not_asked(content: Mapping[str, Any]) -> dict[str, Any]:
    """What a file states of the measurement that the form does not ask for."""
    asked = [what.key for what in OPTIONAL.values()]
    return {key: value for key, value in (content.get("measurement") or {}).items() if key not in asked}


def _optional(name: str, what: Optional, fields: Mapping[str, str]) -> Html:
    return element(
        "fieldset",
        element("legend", f"{what.title} (optional)"),
        element(
            "div",
            element("label", what.label, for_=name),
            number(name, fields.get(name, "")),
            class_="field",
        ),
        element("p", what.hint, class_="muted hint"),
    )


def _constant(name: str, constant: Constant, fields: Mapping[str, str]) -> Html:
    unit = fields.get(f"{name}-unit") or SHOWN[name]
    told = element("dl", element("dt", "Typical"), element("dd", constant.typical), element("dt", "How to measure"),
                   element("dd", constant.measure), class_="told")  # fmt: skip
    return element(
        "fieldset",
        element("legend", f"{constant.title}, ", formula(constant.symbol)),
        element("p", constant.means),
        element(
            "div",
            _field(name, "value", "Value", fields),
            _field(name, "std", "± standard deviation", fields),
            element(
                "div",
                element("label", "Unit", for_=f"{name}-unit"),
                select(f"{name}-unit", ((u, u) for u in constant.units), unit),
                class_="field",
            ),
            class_="row",
        ),
        told,
    )


def _field(name: str, part: str, label: str, fields: Mapping[str, str]) -> Html:
    key = f"{name}-{part}"
    return element(
        "div",
        element("label", label, for_=key),
        number(key, fields.get(key, ""), required=True, size=10),
        class_="field",
    )


def _known(session: Session) -> dict[str, str]:
    """The form's fields of the rig that the session has, if it has one."""
    path, data = session.folder / RIG, session.folder / DATA / "dataset.yaml"
    found = read_rig_file(path) if path.exists() else earlier_rig(data) if data.exists() else None
    if found is None:
        return {}
    fields: dict[str, str] = {}
    for name, constant in CONSTANTS.items():
        unit, scale = SHOWN[name], constant.units[SHOWN[name]]
        prior = getattr(found.prior, name)
        fields |= {
            f"{name}-unit": unit,
            f"{name}-value": f"{prior.value / scale:.10g}",
            f"{name}-std": f"{prior.std / scale:.10g}",
        }
    stated = {name: found.measurement.get(what.key) for name, what in OPTIONAL.items()}
    return fields | {name: f"{value:g}" for name, value in stated.items() if value is not None}


def _content(session: Session) -> dict[str, Any]:
    path = session.folder / RIG
    return read_yaml_mapping(path) if path.exists() else {}


def _number(text: str, where: str, faults: list[str]) -> float | None:
    if not text.strip():
        faults.append(f"{where}: is missing; write it")
        return None
    try:
        return float(text)
    except ValueError:
        faults.append(f"{where}: {shown(text)} is no number; write digits with a point")
        return None


def _named(fault: str) -> str:
    """A message with the form's words in place of the file's keys."""
    for name, key in KEYS.items():
        for part, word in ((".value", ""), (".std", ", standard deviation"), ("", "")):
            fault = fault.replace(f"rig.{key}{part}", f"{CONSTANTS[name].title}{word}")
    for what in OPTIONAL.values():
        fault = fault.replace(f"measurement.{what.key}", what.title)
    return fault

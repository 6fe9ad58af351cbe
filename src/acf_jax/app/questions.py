"""Questions to a session's model: from a form's fields to a call of the library, and to the command that asks the same.

What was asked last of each kind is kept, for the scripts that repeat a session.
"""

import json
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from acf_jax.app.commands import model_file
from acf_jax.app.jobs import FOLDER
from acf_jax.app.sessions import DESIGN, Session
from acf_jax.documents import yaml_text
from acf_jax.errors import InputError, shown
from acf_jax.files import read_json_mapping, write_text

ASKED = f"{FOLDER}/asked.json"
Call = dict[str, Any]  # arguments of `acf_jax.speed`, `design` or `check` behind the model


def call_of(question: str, fields: Mapping[str, str]) -> Call:
    """What a form asks; `InputError` lists what is no number."""
    faults: list[str] = []

    def number(name: str, label: str) -> float:
        text = fields.get(name, "").strip()
        try:
            return float(text)
        except ValueError:
            faults.append(f"{label}: {shown(text)} is no number; write digits with a point")
            return 0.0

    call: Call
    if question == "speed":
        call = {"f_p": number("f_p", "Pretension"), "limit": number("limit", "Limit")}
    elif question == "design":
        call = {
            "limit": number("limit", "Limit"),
            "v_e": (number("v-low", "Lowest velocity"), number("v-high", "Highest velocity")),
            "f_p": (number("f-low", "Least pretension"), number("f-high", "Largest pretension")),
            "goal": fields.get("goal", "fastest"),
        }
    elif question == "check":
        call = {
            "body_area": fields.get("area", ""),
            "v": number("v", "Velocity"),
            "f_p": number("f_p", "Pretension"),
            "contact": fields.get("contact", "quasi_static"),
        }
        if fields.get("stop", "").strip():
            call["stop_after"] = number("stop", "Stopped after")
    else:
        raise InputError(f"question {shown(question)}: is none of {', '.join(COMMANDS)}")
    if faults:
        raise InputError(faults)
    return call


def keep(session: Session, question: str, fields: Mapping[str, str]) -> None:
    """Note a question that was answered; one for the best setting becomes a file that `design` reads."""
    known = {name: one for name, one in _kept(session).items() if name in COMMANDS} | {question: dict(fields)}
    write_text(session.folder / ASKED, json.dumps(known))
    if question == "design":
        call = call_of(question, fields)
        ranges = {name: dict(zip(("low", "high"), call[name], strict=True)) for name in ("v_e", "f_p")}
        content = {"model": model_file(session), "goal": call["goal"], "limit": call["limit"]} | ranges
        write_text(session.folder / DESIGN, yaml_text(content))


def asked(session: Session) -> dict[str, Call]:
    """The last question of each kind."""
    found = {}
    for question in COMMANDS:
        with suppress(InputError, LookupError, AttributeError, TypeError):
            found[question] = call_of(question, _kept(session)[question])
    return found


def _kept(session: Session) -> dict[str, Any]:
    try:
        return read_json_mapping(session.folder / ASKED, "ask again")
    except InputError:
        return {}


def _speed(call: Call, model: str) -> list[str]:
    return ["speed", "--model", model, "--f-p", f"{call['f_p']!r}", "--limit", f"{call['limit']!r}"]


def _design(call: Call, model: str) -> list[str]:
    return ["design", "--config", DESIGN]


def _check(call: Call, model: str) -> list[str]:
    numbers = {"v": "--v-e", "f_p": "--f-p", "stop_after": "--stop-after"}
    given = [part for name, option in numbers.items() if name in call for part in (option, f"{call[name]!r}")]
    return ["check", "--model", model, "--body-area", call["body_area"], "--contact", call["contact"], *given]


COMMANDS = {"speed": _speed, "design": _design, "check": _check}

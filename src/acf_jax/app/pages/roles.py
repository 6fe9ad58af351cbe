"""Step 1, Open: the form that says which signals are force, speed and pretension."""

import json
from collections.abc import Sequence
from typing import Any

from acf_jax.app import signals
from acf_jax.app.pages.layout import button, field, form, hidden, number, options, running, select
from acf_jax.app.sessions import MAPPING, Session
from acf_jax.report.markup import Html, element, void
from acf_jax.si import UNITS

WORDS = {"force": "Force", "speed": "Speed of the robot", "pretension": "Pretension"}
HINTS = {
    "force": "Positive in contact. A force that falls in contact has its sign turned.",
    "speed": "Towards the part. A position is differentiated.",
    "pretension": "What the flange is set to: a signal, or one number for all contacts.",
}
SIGNALS = 400  # that can be chosen


def signals_form(session: Session, content: dict[str, Any], offered: dict[str, Any]) -> Html:
    """The form, filled in with what mapping.yaml says, else with what the recording offers."""
    every = [(c["name"], f) for c in offered.get("channels", []) for f in (c["fields"] or [None])][:SIGNALS]
    rows = [_role(role, content, offered, every) for role in signals.ROLES]
    tare = (content.get("contacts") or {}).get("tare", True) is not False  # as `import` has it
    zero = element(
        "div",
        void("input", type="checkbox", id="tare", name="tare", checked=tare, aria_describedby="tare-hint"),
        element("label", " Zero: take off what the force reads before each contact", for_="tare"),
        element(
            "p",
            "A sensor reads something while nothing is touched: it drifts, or feels its tool's weight.",
            class_="muted hint",
            id="tare-hint",
        ),
    )
    return form(
        f"{session.url}/signals",
        hidden("version", session.version(MAPPING)),
        *rows,
        zero,
        _times(content, offered),
        button("Find the contacts", class_="first", disabled=running(session) is not None),
        id="signals",
    )


def _role(
    role: str, content: dict[str, Any], offered: dict[str, Any], every: Sequence[tuple[str, str | None]]
) -> Html:
    chosen = signals.chosen(content, role)
    candidates = (offered.get("candidates") or {}).get("velocity" if role == "speed" else role) or []
    kind = chosen.key
    value = chosen.value
    if value == signals.AUTO and chosen.number is None and len(candidates) == 1:
        value = signals.value_of(candidates[0]["name"], candidates[0]["field"])
        kind = "position" if role == "speed" and candidates[0].get("is_position") else kind
    proposed = [(signals.value_of(c["name"], c["field"]), called(c["name"], c["field"])) for c in candidates]
    others = [(signals.value_of(n, f), called(n, f)) for n, f in every]
    known = {v for v, _ in (*proposed, *others)}
    named = [] if value in known or value == signals.AUTO else [(value, called(*json.loads(value)))]
    top = [(signals.AUTO, "not chosen")] + (
        [("number", "one number for all contacts")] if role != "force" else []
    )
    groups = [element("optgroup", options(pairs, value), label=label) for label, pairs in (
        ("Proposed", proposed), ("As in mapping.yaml", named),
        ("All signals", [p for p in others if p not in proposed]),
    ) if pairs]  # fmt: skip
    if chosen.number is not None:
        value = "number"
    choice = element(
        "select", options(top, value), *groups, id=role, name=role, aria_describedby=f"{role}-hint"
    )
    units = list(UNITS[kind])
    if chosen.unit not in units:
        units.append(chosen.unit)
    parts = [element("legend", WORDS[role]), field("Signal", choice, role)]
    if role == "speed":
        kinds = (("velocity", "velocity"), ("position", "position"))
        parts.append(field("It is a", select("speed-kind", kinds, kind), "speed-kind"))
    names = [(u, u if u in UNITS[kind] else f"× {u}") for u in units]
    parts.append(field("Unit there", select(f"{role}-unit", names, chosen.unit), f"{role}-unit"))
    parts.append(
        element(
            "div",
            void(
                "input", type="checkbox", id=f"{role}-turned", name=f"{role}-turned", checked=chosen.scale < 0
            ),
            element("label", " Turn the sign", for_=f"{role}-turned"),
            class_="field check",
        )
    )
    if role != "force":
        unit = "m/s" if role == "speed" else "N"
        parts.append(field(f"Or a number, {unit}", number(f"{role}-number", chosen.number), f"{role}-number"))
    parts.append(element("p", HINTS[role], class_="muted hint", id=f"{role}-hint"))
    parts.append(
        button(
            "Preview",
            type="button",
            class_="quietly",
            data_preview=role,
            aria_label=f"Preview of {WORDS[role]}",
        )
    )
    return element("fieldset", *parts)


def _times(content: dict[str, Any], offered: dict[str, Any]) -> Html:
    """The time of a table; a bag's messages bring theirs."""
    names = [c["name"] for c in offered.get("channels", []) if not c["fields"]]
    if not names:
        return Html("")
    time = str(content.get("time") or "")
    pairs = [("", "found by its name"), *((n, n) for n in dict.fromkeys([*([time] if time else []), *names]))]
    inside = [
        field("Column", select("time", pairs, time), "time"),
        field("Or rows per second, Hz", number("rate", content.get("sample_rate_hz")), "rate"),
    ]
    return element("fieldset", element("legend", "Times"), *inside)


def called(name: str, field_name: str | None) -> str:
    """What a person reads of a signal."""
    return f"{name}:{field_name}" if field_name else name

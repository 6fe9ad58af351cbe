"""Whether a contact with a person stays within the limits of ISO/TS 15066."""

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from acf_jax.api._values import not_numbers, path_of, plain
from acf_jax.api.source import ModelLike, Source, source_of
from acf_jax.contact.ending import make_ending
from acf_jax.errors import InputError
from acf_jax.report.check_text import document, highest_said, text
from acf_jax.report.markup import bullets, details, element, join, table
from acf_jax.safety.check import Answer, Checker, Verdict
from acf_jax.safety.limits import BodyArea, Limits, read_limits
from acf_jax.safety.situation import CONFIDENCE, Contact, Situation, situation_faults
from acf_jax.surrogate import load_surrogate

MOODS = {"allowed": "good", "not allowed": "bad", "not decidable": "open"}


@dataclass(frozen=True, repr=False, eq=False)
class Check:
    """The verdict on one contact, with all that it rests on."""

    answer: Answer  # as the library says it
    checker: Checker
    limits: Limits

    @property
    def verdict(self) -> Verdict:
        """`allowed`, `not allowed` or `not decidable`."""
        return self.answer.verdict

    @property
    def is_allowed(self) -> bool:
        """Whether the verdict is `allowed`: the only one on which a contact may be made."""
        return self.answer.verdict == "allowed"

    @property
    def reasons(self) -> tuple[str, ...]:
        """Why."""
        return self.answer.reasons

    @property
    def force(self) -> float | None:
        """Expected force, N; None where the model tells none."""
        return self.answer.force

    @property
    def upper(self) -> float | None:
        """Force that is not exceeded with the stated confidence, N."""
        return self.answer.upper

    @cached_property
    def _document(self) -> dict[str, Any]:
        return document(self.answer, self.checker, self.limits, alone=True)

    @property
    def highest_speed(self) -> float | None:
        """The highest velocity at which this contact is allowed, m/s; None where it never is."""
        return self._document["highest_allowed_velocity_m_per_s"]

    def document(self) -> dict[str, Any]:
        """The verdict as plain numbers and texts, as the command's `--json`."""
        return dict(self._document)

    @cached_property
    def _text(self) -> str:
        return text(self.answer, self.checker, self.limits)

    def __repr__(self) -> str:
        return self._text

    def _repr_html_(self) -> str:
        a, told = self.answer, self._document
        head, *_ = self._text.splitlines()
        word, _, about = head.partition(":")
        rows = [
            ("force, expected", _newtons(a.force)),
            (f"not exceeded with a confidence of {self.checker.confidence:g}", _newtons(a.upper)),
            ("limit", _newtons(a.force_limit)),
            ("pressure", told["pressure_verdict"]),
            (
                "highest velocity allowed",
                highest_said(self.highest_speed, told["highest_allowed_velocity_ended_by"]),
            ),
            ("decided by", a.decided_by),
        ]
        return join(
            [
                element("p", element("strong", word, class_=MOODS[a.verdict]), f":{about}"),
                bullets([*a.reasons, *a.cautions]),
                table(f"Limits of {self.limits.source}", ("", "Value"), rows),
                details("It takes for granted that", bullets(told["assumptions"])),
                element("p", told["statement"]),
            ]
        )


def check(
    model: ModelLike,
    body_area: str,
    *,
    v: float,
    f_p: float,
    contact: Contact = "quasi_static",
    stop_after: float | None = None,
    travel: float | None = None,
    reaction: float | None = None,
    deceleration: float | None = None,
    contact_area: float | None = None,
    moving_mass: float | None = None,
    payload: float | None = None,
    limits: str | Path | None = None,
    confidence: float = 0.975,
    exact: bool = False,
) -> Check:
    """Whether a contact with a person stays within the limits of a body area.

    A calculation replaces neither a measurement nor a risk assessment. docs/safety.md explains the answer.

    **Arguments:** `model`: a diagnosis, a `Rig`, or a path. `body_area`: number or name of an area of the limits, or
    of a region: every area of it is checked. `v`: contact velocity, m/s. `f_p`: pretension, N. `contact`:
    `quasi_static`, the body is clamped, which is the stricter one, or `transient`, it is free to recoil. `stop_after`,
    `travel`, `reaction`, `deceleration`: how the contact ends, as for `speed`. `contact_area`: cm^2, decides the
    pressure. `moving_mass`, `payload`: kg, of the robot, for the standard's own formula. `limits`: own limits, CSV;
    ISO/TS 15066 by default. `confidence`: with which an allowed force is not exceeded. `exact`: never ask a surrogate.

    **Returns:** `Check`, whose `verdict` is `allowed`, `not allowed` or `not decidable`.

    **Raises:** `InputError` that lists what is wrong with the question.

    >>> import acf_jax as acf
    >>> acf.check("configs/check_rig.yaml", "palm", v=0.2, f_p=60.0, stop_after=0.05).verdict
    'allowed'
    """
    source = source_of(model)
    needed = {"v": v, "f_p": f_p, "confidence": confidence}
    told = {"stop_after": stop_after, "travel": travel, "reaction": reaction, "deceleration": deceleration}
    masses = {"contact_area": contact_area, "moving_mass": moving_mass, "payload": payload}
    needed, told, masses = ({name: plain(x) for name, x in given.items()} for given in (needed, told, masses))
    if faults := not_numbers(needed, told | masses):
        raise InputError(faults)
    low, high = CONFIDENCE
    if not low <= needed["confidence"] <= high:
        faults.append(f"confidence must lie between {low} and {high}, but is {confidence!r}; correct it")
    ending, wrong = make_ending(told)
    faults += wrong
    areas: tuple[BodyArea, ...] = ()
    known = None
    try:
        known = read_limits(None if limits is None else path_of(limits))
        areas = known.find(str(body_area))
    except InputError as error:
        faults += error.faults
    if known is None or not areas:
        raise InputError(faults)
    sizes = (masses["contact_area"], masses["moving_mass"], masses["payload"])
    situation = Situation("", areas, contact, needed["v"], needed["f_p"], *sizes, ending=ending)
    own = [fault for fault in situation_faults(situation) if not fault.startswith("ending.")]
    if faults := faults + [re.sub("^v_e ", "v ", fault) for fault in own]:
        raise InputError(faults)
    checker = _checker(source, confidence, exact)
    return Check(checker(situation), checker, known)


def _checker(source: Source, confidence: float, exact: bool) -> Checker:
    """The checker of a model, which is compiled with its first answer."""
    key = (confidence, exact)
    if key not in source.checkers:
        surrogate = None if exact else source.trained or load_surrogate()
        source.checkers[key] = Checker(source.exact, surrogate, confidence)
    return source.checkers[key]


def _newtons(value: float | None) -> str:
    return "not known" if value is None else f"{value:.1f} N"

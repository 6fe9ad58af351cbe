"""Whether a contact stays below the limits of a body area: allowed, not allowed, or not decidable."""

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import jax.numpy as jnp
import numpy as np

from acf_jax.contact.body import Body
from acf_jax.contact.ended import Ended
from acf_jax.contact.ending import Ending
from acf_jax.contact.model import ContactModel
from acf_jax.contact.peak import ClosedForm
from acf_jax.contact.read import by_surrogate
from acf_jax.contact.stop import LONGEST, Stop, ending_conflict, latest_stop, stop_of, stop_words
from acf_jax.designs.boundary import first_failure
from acf_jax.predict import LONGEST as LONGEST_TRACE
from acf_jax.safety import standard
from acf_jax.safety.assumptions import cautions
from acf_jax.safety.infer import (
    Inferred,
    Way,
    at_rest,
    bound,
    compiled,
    exact_peak,
    quick_peak,
    trained_peak,
    whole,
)
from acf_jax.safety.limits import BodyArea, body_of, limits_of
from acf_jax.safety.situation import CONFIDENCE, Situation, situation_faults
from acf_jax.surrogate import CorrectedSurrogate, Surrogate

Verdict = Literal["allowed", "not allowed", "not decidable"]
SEVERITY: dict[Verdict, int] = {"allowed": 0, "not decidable": 1, "not allowed": 2}
STAYS = "at rest"  # the force once robot and flange have stopped, beside those that a verdict is decided by
NEAR = 1e-3  # of the limit: nearer to it the exact model decides
OPEN_END = (
    "it is not stated how the contact ends, and the force can pass the limit as long as the robot goes on"
)
LATE = (
    f"the robot stops later than {LONGEST_TRACE * 1e3:.0f} ms after contact: the model is one of the impact, and for"
    " what follows it is only continued"
)
FASTER = "faster than v_max of the standard's formula: the flange's stroke has to keep the robot's mass away"


class Answer(NamedTuple):
    """The verdict on one situation with everything it rests on; None is what was not decided or does not exist."""

    situation: Situation
    area: BodyArea  # of those that the situation names, the one that decides
    verdict: Verdict
    reasons: tuple[str, ...]
    decided_by: str  # surrogate, exact model, simulation, rule
    cautions: tuple[str, ...] = ()  # what makes the verdict weaker than it looks
    force: float | None = (
        None  # N, expected until the contact has ended; where that is open, of its first peak
    )
    upper: float | None = None  # N, not exceeded with the stated confidence
    lasting: float | None = None  # N, expected of a clamped contact once the robot has stopped
    force_limit: float | None = None  # N
    pressure: float | None = None  # N/cm^2, upper force over the area
    pressure_limit: float | None = None  # N/cm^2
    pressure_verdict: Verdict | None = None  # of the pressure alone
    standard_speed: float | None = (
        None  # m/s, by the standard's formula; None: clamped, or no masses are given
    )
    stop_by: float | None = (
        None  # s, the robot must have stopped by then; infinite: not within what was looked at
    )


class HighestSpeed(NamedTuple):
    """Up to which velocity a situation is allowed, and what ends there."""

    v: float | None  # m/s; None: it is never allowed
    ended_by: Literal["verdict", "tried range", "search"]


class Checker:
    """Answers for one model; compiled with the first situation, quick from then on.

    The surrogate answers where it fits the model and is sure: one of the paper's model for a rig, one of a corrected
    model for the diagnosis it was trained on.

    **Raises:** `ValueError` in single precision, which no bound here allows for, and for a confidence beyond 0.5 to
    0.9999.
    """

    def __init__(
        self,
        model: ContactModel,
        surrogate: Surrogate | CorrectedSurrogate | None = None,
        confidence: float = 0.975,
    ):
        if jnp.zeros(()).dtype != jnp.float64:
            raise ValueError("a check needs double precision; call jax.config.update('jax_enable_x64', True)")
        low, high = CONFIDENCE
        if not low <= confidence <= high:
            raise ValueError(f"confidence must lie between {low} and {high}, but is {confidence!r}")
        self.model = model
        # taken out once: each look into a module costs microseconds, which a check counts
        self.theta, self.tried = tuple(np.asarray(model.main.theta).tolist()), model.tried
        self.verdict = model.verdict
        self.confidence = confidence
        stays = at_rest(model, confidence)
        self.exact = compiled(exact_peak(model, confidence), stays, is_simulated=model.is_simulated)
        self.whole = compiled(whole(model, confidence), is_simulated=True)
        has_closed_form = isinstance(model.main.peak, ClosedForm)
        self.bound = compiled(bound(model, confidence)) if has_closed_form else None
        self.quick: Way | None = None
        if isinstance(surrogate, CorrectedSurrogate):
            trained = by_surrogate(model, surrogate)
            self.quick = compiled(trained_peak(trained, confidence), stays, is_simulated=trained.is_simulated)
        elif surrogate is not None and has_closed_form:
            self.quick = compiled(quick_peak(model, confidence, surrogate), stays, bound(model, confidence))
        self.exact_name = "exact model" if has_closed_form else "simulation"
        self.cautions = cautions(model)

    def __call__(self, situation: Situation) -> Answer:
        """The verdict on one situation: the worst over the areas that it names.

        Allowed: the force that is not exceeded with the stated confidence is below every limit until the contact has
        ended, or for ever where it is not stated how it ends. Not allowed: the expected force is above one, or contact
        with the area is never permissible. Not decidable: everything else, and whatever lies outside the range that the
        model was tried in. Where it is not allowed, `stop_by` says when the robot would have to have stopped.

        **Raises:** `ValueError` for a situation that cannot be: a negative speed, a contact that is no kind of one.
        """
        answer = self.judge(situation)
        if answer.verdict == "allowed" or answer.force_limit is None or self._unanswerable(situation):
            return answer
        stop_by = self._stop_by(situation, answer)
        return answer._replace(stop_by=stop_by, reasons=(*answer.reasons, _advice(situation, stop_by)))

    def judge(self, situation: Situation) -> Answer:
        """The same verdict without looking for `stop_by`, which takes a search: for loops and controllers."""
        if faults := situation_faults(situation):
            raise ValueError("; ".join(faults))
        return self._answer(situation)

    def highest_speed(self, s: Situation, up_to: float = 2.0) -> HighestSpeed:
        """The lowest velocity at which this situation stops being allowed, m/s, or where the search for it ends.

        **Arguments:** `up_to`: m/s, where no tried range is known.
        """
        low, top = self.tried.speeds_at(s.f_p) if self.tried else (0.0, up_to)
        end: Literal["tried range", "search"] = "tried range" if self.tried else "search"

        def holds(shares: np.ndarray) -> np.ndarray:
            speeds = (1 - shares) * low + shares * top
            return np.array([self._answer(s._replace(v_e=float(v))).verdict == "allowed" for v in speeds])

        found = first_failure(holds)
        if found is None:
            return HighestSpeed(None, "verdict")
        v = (1 - found.last_held) * low + found.last_held * top
        return HighestSpeed(v, end if np.isinf(found.first_failed) else "verdict")

    def _answer(self, s: Situation) -> Answer:
        for area in s.areas:
            if not area.is_permissible:
                never = f"contact with {area.region.lower()} is not permissible, whatever the force"
                return Answer(s, area, "not allowed", (never,), "rule", pressure_verdict="not allowed")
        known: dict[tuple[Body, str], Inferred] = {}  # areas of one region often share their mechanics
        answers = [self._of_area(s, area, known) for area in s.areas]
        return max(answers, key=_severity) if len(answers) > 1 else answers[0]

    def _of_area(self, s: Situation, area: BodyArea, known: dict[tuple[Body, str], Inferred]) -> Answer:
        force_limit, pressure_limit = limits_of(area, s.contact)
        lowest = _lowest_limit(s, force_limit, pressure_limit)
        body = body_of(area, s.contact)
        found, way = self._infer(s, body, lowest, known)
        stays = known[body, STAYS]
        if not s.ending.is_known and found.exists and found.upper <= lowest:
            later = self._bound(s, body, known)
            is_open = later > lowest
            found = found if is_open else found._replace(upper=max(found.upper, later))
        else:
            is_open = False
        force, above = (found.force, found.upper) if found.exists else (None, None)
        pressure = above / s.contact_area if above is not None and s.contact_area else None
        of_pressure: Verdict | None = None
        if reasons := [*self._unanswerable(s), *self._unanswered(s, found)]:
            verdict: Verdict = "not decidable"
            if pressure is not None and pressure_limit is not None:
                of_pressure = verdict
        else:
            judged = [self._judge(s, found, stays, "force", "N", 1.0, force_limit, area.force)]
            if s.contact_area and pressure_limit is not None:
                lasting, share = area.pressure or 0.0, 1 / s.contact_area
                judged.append(
                    self._judge(s, found, stays, "pressure", "N/cm^2", share, pressure_limit, lasting)
                )
                of_pressure = judged[-1][0]
            if is_open:
                judged.append(("not decidable", [OPEN_END]))
            verdict = max((one for one, _ in judged), key=SEVERITY.__getitem__)
            reasons = [reason for one, why in judged if one == verdict for reason in why]
        speed = standard_speed(s, area, lowest)
        faster = FASTER if speed is not None and s.v_e > speed else ""
        stop = stop_of(s.ending, s.v_e)
        late = LATE if LONGEST_TRACE < stop.time < np.inf else ""
        cautions = (*self.cautions, *filter(None, (area.caution, faster, late)))
        is_pressed = s.contact == "quasi_static" and stop.travel < np.inf
        lasting_force = stays.force if is_pressed else None
        return Answer(
            s, area, verdict, tuple(reasons), way, cautions, force, above, lasting_force, force_limit, pressure,
            pressure_limit, of_pressure, speed,
        )  # fmt: skip

    def _ask(
        self,
        way: Way,
        names: Sequence[str],
        s: Situation,
        body: Body,
        known: dict[tuple[Body, str], Inferred],
    ) -> Inferred:
        """What the first program of a way infers; what the others do, is noted under their names."""
        if (body, names[0]) not in known:
            found = way(np.array([*self.theta, s.v_e, s.f_p, *body, *s.ending]))
            known |= {(body, name): one for name, one in zip(names, found, strict=False)}
        return known[body, names[0]]

    def _infer(
        self, s: Situation, body: Body, limit: float, known: dict[tuple[Body, str], Inferred]
    ) -> tuple[Inferred, str]:
        """The first peak of a contact whose end is open; otherwise the largest force until it has ended."""
        first, name = self._first_peak(s, body, limit, known)
        if not s.ending.is_known:
            return first, name
        above = self._bound(s, body, known)
        if above <= limit and first.is_known:
            return first._replace(force=min(first.force, above), upper=above), name
        return self._ask(self.whole, ["whole"], s, body, known), self.exact_name

    def _first_peak(
        self, s: Situation, body: Body, limit: float, known: dict[tuple[Body, str], Inferred]
    ) -> tuple[Inferred, str]:
        if self.quick is not None:
            found = self._ask(self.quick, ["surrogate", STAYS, "bound"], s, body, known)
            near = found.lower <= limit * (1 + NEAR) and found.upper >= limit * (1 - NEAR)
            if found.is_known and not near:
                return found, "surrogate"
        return self._ask(self.exact, [self.exact_name, STAYS], s, body, known), self.exact_name

    def _bound(self, s: Situation, body: Body, known: dict[tuple[Body, str], Inferred]) -> float:
        """What the force does not exceed until the contact has ended, N; infinite where no bound is known."""
        if self.bound is None:
            return np.inf
        found = self._ask(self.bound, ["bound"], s, body, known)
        return found.upper if found.is_known else np.inf

    def _stop_by(self, s: Situation, answer: Answer) -> float | None:
        """When the robot must have stopped at the latest, at its speed until then."""
        body = body_of(answer.area, s.contact)
        limit = _lowest_limit(s, *limits_of(answer.area, s.contact))

        def keeps(time: float) -> bool:
            ending = Ending(stop_after=time, travel=s.ending.travel)
            (found,) = self.whole(np.array([*self.theta, s.v_e, s.f_p, *body, *ending]))
            return found.is_known and found.upper <= limit

        return latest_stop(keeps)

    def _unanswerable(self, s: Situation) -> list[str]:
        """Why no force could decide."""
        beyond = self.tried.beyond(s.v_e, s.f_p) if self.tried else []
        reasons = [f"{fault}: never allowed by extrapolation" for fault in beyond]
        if self.verdict == "insufficient_data":
            reasons.append(self.model.doubt)
        if fault := ending_conflict(self.model, s.ending, s.v_e):
            reasons.append(fault)
        return reasons

    def _unanswered(self, s: Situation, found: Inferred) -> list[str]:
        """Why the model does not tell the force."""
        if found.exists and found.is_known and math.isfinite(found.upper):
            return []
        within = "" if not found.exists else "within what its parameters and explanations leave open, "
        if s.ending.is_known:
            return [f"{within}{Ended.no_peak}"]
        rises = "the force may keep rising" if found.exists else "the force keeps rising"
        return [f"{within}the model has no answer: {rises} without a first peak{self._too_stiff}"]

    @property
    def _too_stiff(self) -> str:
        return "" if self.exact_name == "exact model" else ", or the contact is too stiff to be simulated"

    def _judge(
        self,
        s: Situation,
        found: Inferred,
        stays: Inferred,
        what: str,
        unit: str,
        share: float,
        limit: float,
        lasting_limit: float,
    ) -> tuple[Verdict, list[str]]:
        """The verdict on the force, or on the pressure as a share of it, by itself."""
        lower, upper, lasting = found.lower * share, found.upper * share, stays.upper * share
        if lower > limit:
            return "not allowed", [
                f"{what} {lower:.4g} {unit} expected, above the limit of {limit:.4g} {unit}"
            ]
        open_ = []
        if upper > limit:
            open_.append(
                f"{what} {lower:.4g} {unit} expected, but with {self.confidence:.3g} confidence only below"
                f" {upper:.4g} {unit}: the limit of {limit:.4g} {unit} lies between"
            )
        if s.contact == "transient" and lasting > lasting_limit:
            open_.append(
                f"the flange goes on pressing when the impact is over: {what} of up to {lasting:.4g} {unit}, above the"
                f" lasting limit of {lasting_limit:.4g} {unit}; check quasi_static, or lower the pretension"
            )
        if open_:
            return "not decidable", open_
        return "allowed", [f"{what} below {upper:.4g} {unit}, limit {limit:.4g} {unit}"]


def _severity(a: Answer) -> tuple[int, float]:
    """The verdict, then how much of its limits a contact uses up."""
    used = [
        value / limit
        for value, limit in ((a.upper, a.force_limit), (a.pressure, a.pressure_limit))
        if value is not None and limit
    ]
    return SEVERITY[a.verdict], max(used, default=np.inf)


def _advice(s: Situation, stop_by: float | None) -> str:
    """By when the robot would have to have stopped."""
    if stop_by is None:
        return "no stop is soon enough"
    if stop_by == np.inf:
        return f"for {LONGEST:g} s the force keeps the limit; state by when the robot has stopped"
    return f"the robot must have stopped within {stop_words(Stop(stop_by, stop_by * s.v_e))} of first contact"


def standard_speed(s: Situation, area: BodyArea, force_limit: float) -> float | None:
    """v_max of the standard's formula, where the robot's masses are given; it is for a body that can recoil."""
    if s.contact != "transient" or s.moving_mass is None or s.payload is None:
        return None
    mass = standard.robot_mass(s.moving_mass, s.payload)
    return standard.highest_speed(force_limit, area.stiffness, area.mass, mass)


def _lowest_limit(s: Situation, force_limit: float, pressure_limit: float | None) -> float:
    """The force at which the first of the limits is reached, N."""
    if s.contact_area and pressure_limit is not None:
        return min(force_limit, pressure_limit * s.contact_area)
    return force_limit

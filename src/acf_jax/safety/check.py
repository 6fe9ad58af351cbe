"""Whether a contact stays below the limits of a body area: allowed, not allowed, or not decidable."""

from typing import Literal, NamedTuple

import numpy as np
from scipy.stats import norm

from acf_jax.contact.body import Body
from acf_jax.contact.model import ContactModel, extrapolated
from acf_jax.contact.peak import ClosedForm
from acf_jax.contact.read import by_surrogate
from acf_jax.design.boundary import first_failure
from acf_jax.safety import standard
from acf_jax.safety.infer import Inferred, Way, exact_way, quick_way, trained_way
from acf_jax.safety.situation import Situation
from acf_jax.surrogate import CorrectedSurrogate, Surrogate

Verdict = Literal["allowed", "not allowed", "not decidable"]
NEAR = 1e-3  # of the limit: nearer to it the exact model decides


class Answer(NamedTuple):
    """The verdict on one situation with everything it rests on."""

    situation: Situation
    verdict: Verdict
    reasons: tuple[str, ...]
    force: float | None  # N, expected peak of the contact force
    upper: float | None  # N, not exceeded with the stated confidence
    force_limit: float | None  # N
    pressure: float | None  # N/cm^2, upper force over the area; None: not decided
    pressure_limit: float | None  # N/cm^2
    standard_speed: float | None  # m/s, v_max of the standard's formula; None: its masses are not given
    decided_by: str  # surrogate, exact model, simulation, rule


class Checker:
    """Answers for one model; compiled with the first situation, quick from then on.

    The surrogate answers where it fits the model and is sure: one of the paper's model for a rig, one of a corrected
    model for the diagnosis it was trained on.
    """

    def __init__(
        self,
        model: ContactModel,
        surrogate: Surrogate | CorrectedSurrogate | None = None,
        confidence: float = 0.975,
    ):
        self.model = model
        # taken out once: each look into a module costs microseconds, which a check counts
        self.theta, self.tried = tuple(np.asarray(model.main.theta).tolist()), model.tried
        self.confidence = confidence
        self.factor = float(norm.ppf(confidence))
        self.exact = exact_way(model)
        has_closed_form = isinstance(model.main.peak, ClosedForm)
        self.quick: Way | None = None
        if isinstance(surrogate, CorrectedSurrogate):
            self.quick = trained_way(by_surrogate(model, surrogate))
        elif surrogate is not None and has_closed_form:
            self.quick = quick_way(model, surrogate)
        self.exact_name = "exact model" if has_closed_form else "simulation"

    def __call__(self, situation: Situation) -> Answer:
        """The verdict on one situation.

        Allowed: the force that is not exceeded with the stated confidence is below every limit. Not allowed: the
        expected force is above one, or contact with the area is never permissible. Not decidable: everything else,
        and whatever lies outside the range that the model was tried in.
        """
        s = situation
        if not s.area.is_permissible:
            never = f"contact with {s.area.region.lower()} is not permissible, whatever the force"
            return Answer(s, "not allowed", (never,), None, None, None, None, None, None, "rule")
        force_limit, pressure_limit = limits_of(s)
        highest = _lowest_limit(s, force_limit, pressure_limit)
        z, body = np.array([*self.theta, s.v_e, s.f_p]), body_of(s)
        found, way = self._infer(z, body, highest)
        upper = found.upper + self.factor * found.std
        reasons = [
            f"{fault}: never allowed by extrapolation" for fault in extrapolated(self.tried, s.v_e, s.f_p)
        ]
        if not found.is_known or not np.isfinite(upper):
            reasons.append("the force keeps rising without a first peak: the model has no answer")
        verdict: Verdict = "not decidable"
        pressure = upper / s.contact_area if s.contact_area else None
        if not reasons:
            verdict, reasons = self._judge(s, found, upper, force_limit, pressure_limit)
        speed = standard_speed(s, force_limit)
        force, above, pressure = (found.upper, upper, pressure) if found.is_known else (None, None, None)
        return Answer(
            s, verdict, tuple(reasons), force, above, force_limit, pressure, pressure_limit, speed, way
        )

    def highest_speed(self, s: Situation, up_to: float = 2.0) -> float | None:
        """The lowest velocity at which this situation stops being allowed, m/s; None where it never is."""
        top = min(up_to, self.model.tried[0][1]) if self.model.tried else up_to
        low = self.model.tried[0][0] if self.model.tried else 0.0

        def holds(shares: np.ndarray) -> np.ndarray:
            speeds = (1 - shares) * low + shares * top
            return np.array([self(s._replace(v_e=float(v))).verdict == "allowed" for v in speeds])

        found = first_failure(holds)
        return None if found is None else (1 - found.last_held) * low + found.last_held * top

    def _infer(self, z: np.ndarray, body: Body, limit: float) -> tuple[Inferred, str]:
        if self.quick is not None:
            found = self.quick(z, body)
            above = found.upper + self.factor * found.std
            near = found.lower <= limit * (1 + NEAR) and above >= limit * (1 - NEAR)
            if found.is_known and not near:
                return found, "surrogate"
        return self.exact(z, body), self.exact_name

    def _judge(
        self, s: Situation, found: Inferred, upper: float, force_limit: float, pressure_limit: float | None
    ) -> tuple[Verdict, list[str]]:
        checks = [("force", "N", found.lower, upper, force_limit)]
        if s.contact_area and pressure_limit is not None:
            share = 1 / s.contact_area
            checks.append(("pressure", "N/cm^2", found.lower * share, upper * share, pressure_limit))
        over = [
            f"{what} {low:.4g} {unit} expected, above the limit of {limit:.4g} {unit}"
            for what, unit, low, _, limit in checks
            if low > limit
        ]
        if over:
            return "not allowed", over
        open_ = [
            f"{what} {low:.4g} {unit} expected, but with {self.confidence:.3g} confidence only below {high:.4g} {unit}:"
            f" the limit of {limit:.4g} {unit} lies between"
            for what, unit, low, high, limit in checks
            if high > limit
        ]
        if open_:
            return "not decidable", open_
        below = [
            f"{what} below {high:.4g} {unit}, limit {limit:.4g} {unit}"
            for what, unit, _, high, limit in checks
        ]
        return "allowed", below


def limits_of(s: Situation) -> tuple[float, float | None]:
    """Force (N) and pressure (N/cm^2) that hold in a situation: the factors belong to the limit, never to the force."""
    if s.contact == "quasi_static":
        return s.area.force, s.area.pressure
    pressure, factor = s.area.pressure, s.area.pressure_factor
    is_given = pressure is not None and factor is not None
    return s.area.force * (s.area.force_factor or 0.0), pressure * factor if is_given else None  # type: ignore[operator]


def body_of(s: Situation) -> Body:
    """The area's stiffness, and its mass where it can recoil."""
    return Body(1 / s.area.stiffness, 1 / s.area.mass if s.contact == "transient" else 0.0)


def standard_speed(s: Situation, force_limit: float) -> float | None:
    """v_max of the standard's formula, where the robot's masses are given."""
    if s.moving_mass is None or s.payload is None:
        return None
    mass = standard.robot_mass(s.moving_mass, s.payload)
    return standard.highest_speed(force_limit, s.area.stiffness, s.area.mass, mass)


def _lowest_limit(s: Situation, force_limit: float, pressure_limit: float | None) -> float:
    """The force at which the first of the limits is reached, N."""
    if s.contact_area and pressure_limit is not None:
        return min(force_limit, pressure_limit * s.contact_area)
    return force_limit


def assumptions(model: ContactModel, s: Situation, confidence: float) -> list[str]:
    """What an answer takes for granted."""
    found = [f"the force is the true one at the contact, by {model.source}; no sensor's reading"]
    if model.main.peak.credits_stiffness():
        found.append(f"the body's {s.area.stiffness / 1e3:g} N/mm act in series with the pad's stiffness")
    else:
        found.append(
            "the pad's law is not linear: the body's stiffness is left out, which overstates the force"
        )
    if s.contact == "transient":
        found.append(
            f"the body can recoil with {s.area.mass:g} kg and withdraw; if it can be clamped, check quasi_static"
        )
    else:
        found.append(
            "the body is clamped; the whole force, its first peak included, is held against the lasting limit"
        )
    found.append(
        "the flange stays within its stroke and the robot stops before the force rises again; at the stroke's end"
        " the robot's own mass would act"
    )
    if s.contact_area:
        found.append(f"the force spreads evenly over {s.contact_area:g} cm^2; edges press harder")
    if not np.any(model.relative) and not np.any(model.main.covariance):
        found.append("the model's parameters are taken as exact: no standard deviations were given")
    else:
        found.append(f"limits are held with a confidence of {confidence:g} over the parameters' uncertainty")
    if model.tried is None:
        found.append("no tried range is known for this model: its values are the user's responsibility")
    return found


STATEMENT = (
    "This is a calculation. It does not replace a measurement of force and pressure (ISO/PAS 5672) or a risk"
    " assessment (ISO 12100)."
)

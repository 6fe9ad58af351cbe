"""What a verdict takes for granted, and what makes it weaker than it looks."""

import numpy as np

from acf_jax.contact.body import series_stiffness
from acf_jax.contact.model import ContactModel
from acf_jax.contact.peak import RIG, ClosedForm, Learned
from acf_jax.contact.stop import stop_of
from acf_jax.safety.limits import BodyArea, body_of
from acf_jax.safety.situation import Situation

LARGE = 0.3  # of a parameter: up to this deviation the confidence has been measured


def cautions(model: ContactModel) -> tuple[str, ...]:
    """What makes every verdict by this model weaker than it looks."""
    found = []
    if model.tried is None:
        found.append(
            "range unknown: the model names no tried v_e and f_p, so that nothing counts as extrapolation"
        )
    large = [name for name, share in zip(model.names, model.relative, strict=True) if share > LARGE]
    if large:
        found.append(
            f"uncertain by more than {LARGE:.0%}: {', '.join(large)}; the confidence holds roughly only"
        )
    if model.doubt and model.verdict != "insufficient_data":  # which is a reason to decide nothing
        found.append(model.doubt)
    return tuple(found)


def assumptions(model: ContactModel, s: Situation, area: BodyArea, confidence: float) -> list[str]:
    """What an answer on one area takes for granted."""
    found = [f"the force is the true one at the contact, by {model.source}; no sensor's reading"]
    if model.main.peak.credits_stiffness():
        k_c = float(model.main.theta[RIG.index("k_c")])
        both = series_stiffness(k_c, body_of(area, s.contact)) / 1e3
        untried = (
            "; the tried range is one of speed and pretension, not of so soft a contact"
            if model.tried
            else ""
        )
        found.append(
            f"the body's {area.stiffness / 1e3:g} N/mm act in series with the pad's stiffness, {both:.3g} N/mm in"
            f" all{untried}"
        )
    else:
        found.append(
            "the pad's law is not linear: the body's stiffness is left out, which overstates the force"
        )
    if s.contact == "transient":
        found.append(
            f"the body can recoil with {area.mass:g} kg and withdraw; if it can be clamped, check quasi_static"
        )
    else:
        found.append(
            "the body is clamped; the whole force, its first peak included, is held against the lasting limit, and so"
            " is the force that stays once the robot has stopped"
        )
    found.append(_end(s))
    if s.contact_area:
        side = 10.0 * s.contact_area**0.5
        found.append(
            f"the force spreads evenly over {s.contact_area:g} cm^2, a square of {side:.3g} mm; edges press harder"
        )
    if not np.any(model.relative) and not np.any(model.main.covariance):
        found.append("the model's parameters are taken as exact: no standard deviations were given")
    else:
        found.append(f"limits are held with a confidence of {confidence:g} over the parameters' uncertainty")
    is_of_diagnosis = not isinstance(model.main.peak, ClosedForm | Learned)
    if is_of_diagnosis and model.verdict is None:
        found.append("the diagnosis identified the cause: the model's file does not say so")
    return found


def _end(s: Situation) -> str:
    """How the contact ends."""
    if not s.ending.is_known:
        return (
            "how the contact ends is not stated; whatever the force does, the flange stays within its stroke, at whose"
            " end the robot's own mass would act"
        )
    stop = stop_of(s.ending, s.v_e)
    until = "until then it keeps its speed"
    if s.ending.brakes:
        until = f"from {1e3 * s.ending.reaction:g} ms on it brakes with {s.ending.deceleration:g} m/s^2"
    return (
        f"the robot has stopped {1e3 * stop.time:.4g} ms and {1e3 * stop.travel:.4g} mm after first contact, and the"
        f" flange has that much of its stroke left; {until}, and what the flange does when it stops counts"
    )


STATEMENT = (
    "This is a calculation. It does not replace a measurement of force and pressure (ISO/PAS 5672:2023) or a risk"
    " assessment (ISO 12100)."
)

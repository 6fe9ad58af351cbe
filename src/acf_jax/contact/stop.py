"""When and where the robot stops, and by when it has to."""

import math
from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from acf_jax.contact.braking import ROUNDING, stopping_time, stopping_travel
from acf_jax.contact.ending import Ending
from acf_jax.contact.model import ContactModel
from acf_jax.contact.peak import BRAKES_ITSELF, Simulated

EARLIEST, LONGEST = 1e-4, 1.0  # s, between which a stop is looked for
HALVINGS = 16  # of the logarithm: to 2 in 10,000


class Stop(NamedTuple):
    """Where an ending leaves the robot; infinite where nothing tells."""

    time: float  # s since first contact
    travel: float  # m


def stop_of(ending: Ending, v_e: float) -> Stop:
    """The stop of an ending at a contact velocity."""
    if not ending.is_known:
        return Stop(math.inf, math.inf if v_e > 0 else 0.0)
    return Stop(*np.asarray(_stop(np.array([*ending, v_e]))).tolist())


@jax.jit  # one operation by itself costs as much as a check
def _stop(x: Float[Array, "5"]) -> Float[Array, "2"]:
    ending = Ending(*x[:-1])
    return jnp.stack([stopping_time(ending, x[-1]), stopping_travel(ending, x[-1])])


def ending_conflict(model: ContactModel, ending: Ending, v_e: float) -> str:
    """Why an ending cannot be of this contact, with the remedy; empty where it can."""
    if ending.brakes:
        laws = [v.peak.original() for v in model.variants]
        if any(isinstance(law, Simulated) and BRAKES_ITSELF in law.effects for law in laws):
            return "the corrected model brakes the robot itself: state its end by stop_after or travel"
    travel = stop_of(ending, v_e).travel
    if math.isfinite(travel) and travel > ending.travel * (1 + ROUNDING):
        return (
            f"the robot travels {1e3 * travel:.3g} mm until it has stopped, more than the {1e3 * ending.travel:g} mm"
            " that are left; at the end of the stroke its own mass would act"
        )
    return ""


def latest_stop(keeps: Callable[[float], bool]) -> float | None:
    """The last time after which the robot may have stopped, s: `keeps` tells it of one, and fails from then on.

    Infinite where it holds for a second, None where it does not even for 0.1 ms.
    """
    if keeps(LONGEST):
        return math.inf
    low, high = math.log(EARLIEST), math.log(LONGEST)
    is_known = False  # whether any stop is soon enough
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        if keeps(math.exp(middle)):
            low, is_known = middle, True
        else:
            high = middle
    return math.exp(low) if is_known or keeps(EARLIEST) else None


def stop_words(stop: Stop) -> str:
    """`15.1 ms or 14.8 mm`, neither rounded up."""
    ms, mm = (math.floor(1e4 * x) / 10 for x in stop)
    return f"{ms:g} ms or {mm:g} mm"

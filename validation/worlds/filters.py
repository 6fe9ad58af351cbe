"""Linear sensors, solved exactly for a force that is linear between the points of a fine grid."""

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy import signal

from validation.worlds.interface import Array


def low_pass(time: Array, force: Array, numerator: ArrayLike, denominator: ArrayLike) -> Array:
    """Answer of numerator(s)/denominator(s), at rest before time 0, to a force that steps at time 0, N.

    The step is answered with a zero-order hold and the rest with a first-order hold, both exact.
    """
    coefficients = tuple(np.ravel(numerator).tolist()), tuple(np.ravel(denominator).tolist())
    step = float(time[1] - time[0])
    constant = signal.lfilter(*_discrete(*coefficients, step, "zoh"), np.full_like(force, force[0]))
    return np.asarray(constant + signal.lfilter(*_discrete(*coefficients, step, "foh"), force - force[0]))


@lru_cache
def _discrete(
    numerator: tuple[float, ...], denominator: tuple[float, ...], step: float, hold: str
) -> tuple[Array, Array]:
    b, a, _ = signal.cont2discrete((numerator, denominator), step, method=hold)
    return np.ravel(b), a

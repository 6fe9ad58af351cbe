"""Readings at the end of the sensor's range: all they say is that the force was at least as large."""

import numpy as np
from scipy.special import log_ndtr

FAR = 1e4  # standard deviations below a bound, from which on it counts as a reading: the rest is rounding


def at_least(excess: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The residual r of a lower bound, and the share of the prediction's derivative that it has.

    With z the predicted force less the bound in standard deviations of the noise, r(z) = sqrt(-2 log Phi(z)) and
    -dr/dz, so that half of r squared is the exact negative log likelihood of a censored reading (Tobin, Econometrica
    26, 1958). max(-z, 0) would be simpler, but says nothing where the force only just reaches the bound: of the
    readings there those that noise lifts are bounds, and those that it lowers would pull the force down alone.

    **Arguments:** `excess`: z, any shape.

    **Returns:** r and -dr/dz, of that shape: -z and 1 far below the bound, 0 and 0 far above it.
    """
    with np.errstate(invalid="ignore", over="ignore"):  # of an unstable integration
        bound = np.sqrt(-2 * log_ndtr(excess))
        hazard = np.exp(-0.5 * excess**2 - log_ndtr(excess)) / np.sqrt(2 * np.pi)
        slope = np.where(excess < -FAR, 1.0, hazard / np.where(bound > 0, bound, 1.0))
    return bound, slope

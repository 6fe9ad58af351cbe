"""Peaks that fits predict at the tried conditions, and whether two explanations mean the same for them."""

from collections.abc import Sequence

import numpy as np

from acf_jax.diagnosis.fit import Fit
from acf_jax.diagnosis.forward import forward
from acf_jax.diagnosis.observe import Observations
from acf_jax.diagnosis.sample import at_times, peak_of


def peaks_of(observations: Observations, fitted: Fit) -> tuple[np.ndarray, np.ndarray]:
    """Peak of the sensed force of each trial at its commanded condition, and its standard deviation, N.

    The deviation holds the parameters' uncertainty and the spread of velocity and pretension from trial to trial.
    """
    o = observations
    theta = fitted.physical
    forces = forward(fitted.explanation, theta, o.v_e, o.f_p, fitted.grid)
    p = len(theta)
    covariance = fitted.covariance[:p, :p]
    peaks, stds = np.zeros(len(o.names)), np.zeros(len(o.names))
    for i in range(len(o.names)):
        peaks[i], when = peak_of(forces.sensed[i], fitted.grid.h, forces.contact[i])
        at_peak = at_times(forces.tangents[i], np.array([when]), fitted.grid.h, forces.contact[i])[:, 0]
        spread = at_peak[p:] * o.nuisance_std[i, :2]
        stds[i] = np.sqrt(at_peak[:p] @ covariance @ at_peak[:p] + (spread**2).sum())
    return peaks, stds


def same_peaks(observations: Observations, reference: Fit, others: Sequence[Fit]) -> bool:
    """Whether no other fit changes the peak of any trial by more than twice its standard deviation."""
    peaks, stds = peaks_of(observations, reference)
    for other in others:
        if other is reference:
            continue
        changed, own = peaks_of(observations, other)
        if (np.abs(changed - peaks) > 2 * np.maximum(stds, own)).any():
            return False
    return True

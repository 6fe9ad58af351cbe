"""Peaks as measured, as fits predict them, and whether two explanations mean the same for them."""

from collections.abc import Sequence

import numpy as np

from acf_jax.dataset import Quality
from acf_jax.inference.fit import Fit
from acf_jax.inference.forward import forward
from acf_jax.inference.interpolation import at_times, peak_of
from acf_jax.inference.observations import Observations


def measured_peaks(quality: Quality, observations: Observations) -> np.ndarray:
    """(trials,) the largest sample within the impact phase of each, N, what an unloaded sensor reads taken off.

    Not known, nan, where the force is cut off, unless trials.csv has a higher peak.
    """
    by_name = {t.name: (t, q) for t, q in zip(quality.dataset.trials, quality.trials, strict=True)}
    peaks = []
    for name in observations.names:
        trial, look = by_name[name]
        if look.phase is None:
            peaks.append(np.nan if look.peak_is_bound else trial.peak_force)
        elif look.phase.cut_off is None:
            peaks.append(look.phase.peak_force - quality.noise.offset)
        else:
            stated = trial.peak_force or 0.0
            peaks.append(stated - quality.noise.offset if stated > look.phase.peak_force else np.nan)
    return np.array(peaks, float)


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

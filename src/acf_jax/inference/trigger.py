"""How far triggers scatter about their common time, told by repeats of a condition alone: no model is needed."""

from dataclasses import replace

import numpy as np
from scipy.linalg import helmert

from acf_jax.inference.observations import TRIGGER, Observations
from acf_jax.inference.whitening import Whitener

SIZES = np.geomspace(0.02, TRIGGER, 33)  # that are tried, in sampling intervals
ALLOWED = 2.0  # log likelihood by which the size taken is worse than the best: twice its standard deviation
UNLIKE = (
    4.0  # mean square of what no trigger explains, over the noise's: such repeats tell nothing of triggers
)
SAME = 0.01  # of an interval, to which repeats have to be sampled alike


def with_scatter(observations: Observations) -> Observations:
    """The same observations, with the scatter of their own triggers."""
    return replace(observations, trigger_std=trigger_scatter(observations))


def trigger_scatter(observations: Observations) -> float:
    """Standard deviation of trigger times, in sampling intervals: the largest that the repeats allow.

    Differences between repeats hold noise, and what the scatter of trigger, velocity and pretension makes of the
    condition's mean trace: its slope, itself and a constant. Their likelihood is computed for each of `SIZES`; without
    repeats every size is as good, and the largest one stands.
    """
    total = np.zeros(len(SIZES))
    for condition in np.unique(observations.condition):
        trials = np.flatnonzero((observations.condition == condition) & observations.traced.any(1))
        if len(trials) > 1:
            total += _log_likelihood(observations, trials)
    return float(SIZES[total >= total.max() - ALLOWED].max())


def _log_likelihood(o: Observations, trials: np.ndarray) -> np.ndarray:
    """(len(SIZES),) of the differences between trials of one condition; zeros where these cannot be compared."""
    samples = o.used[trials].all(0)
    time = o.time[trials][:, samples]
    interval = float(o.interval[trials[0]])
    if len(time[0]) < 3 or np.ptp(time, axis=0).max() > SAME * interval:
        return np.zeros(len(SIZES))
    force = o.force[trials][:, samples]
    mean = force.mean(0)
    changes = np.stack(
        [
            interval * np.gradient(mean, time[0]),
            o.rel_std[0] * mean,
            np.full(len(mean), o.rel_std[1] * o.f_p[trials[0]]),
        ]
    )
    signals = np.concatenate([changes, helmert(len(trials)) @ force])
    (white,) = Whitener(time[:1], np.ones_like(time[:1], bool), o.noise)(signals[None])
    changes, differences = white[: len(changes)], white[len(changes) :]
    value = []
    for size in SIZES:
        scaled = changes * np.array([size, 1.0, 1.0])[:, None]
        inner = np.eye(len(scaled)) + scaled @ scaled.T
        seen = differences @ scaled.T
        explained = np.einsum("ka,ak->", seen, np.linalg.solve(inner, seen.T))
        left = float((differences**2).sum()) - explained
        value.append(0.5 * (explained - len(differences) * np.linalg.slogdet(inner)[1]))
    # with the largest scatter, which explains most
    return np.array(value) if left < UNLIKE * differences.size else np.zeros(len(SIZES))

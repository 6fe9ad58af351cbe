"""What the repeats of a condition say of scatter: their differences hold nothing that a model predicts."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import helmert

from acf_jax.inference.observations import Observations
from acf_jax.inference.ring import Ring, ringing
from acf_jax.inference.whitening import Whitener

SAME = 0.01  # of an interval, by which samples that lie half of one apart may lie farther apart
FEWEST = 3  # samples that repeats have to share: their slope is needed


class Repeats(NamedTuple):
    """The trials of one condition; `changes` and `differences` in units of independent noise."""

    time: np.ndarray  # (n,) s
    largest: float  # N, force of the mean trace
    whiten: Whitener  # of one trial
    changes: (
        np.ndarray
    )  # (3, n) of the mean trace by one standard deviation of velocity, pretension and trigger
    contrasts: np.ndarray  # (trials - 1, n) N, orthonormal: each scatters as a trace does
    differences: np.ndarray  # (trials - 1, n) the same in units of independent noise

    def seen(self, rings: Sequence[Ring]) -> np.ndarray:
        """(2 rings, n) one standard deviation of each ring's parts."""
        return self._white(ringing(rings, self.time[None], np.array([self.largest]))[0])

    def explained(self, spread: np.ndarray) -> float:
        """Chi-square that scatter takes of the differences; `spread`: (k, n) by one standard deviation of each."""
        inner, on = _inner(spread), spread @ self.differences.T
        return float((on * np.linalg.solve(inner, on)).sum())

    def left(self, spread: np.ndarray) -> float:
        """Chi-square of a sample that scatter does not take; arguments as of `explained`."""
        return (float((self.differences**2).sum()) - self.explained(spread)) / self.differences.size

    def log_likelihood(self, spread: np.ndarray) -> float:
        """Of the differences with that scatter, up to a constant."""
        volume = float(np.linalg.slogdet(_inner(spread))[1])
        return 0.5 * (self.explained(spread) - len(self.differences) * volume)

    def gains(self, shapes: np.ndarray, sizes: np.ndarray, spread: np.ndarray) -> np.ndarray:
        """(shapes, sizes) log likelihood that a shape of two parts, (shapes, 2, n) N, gains beside a spread."""
        n = len(self.time)
        columns = self._white(shapes.reshape(-1, n)).reshape(-1, 2, n)
        inner, on = np.linalg.inv(_inner(spread)), columns @ spread.T
        gram = columns @ columns.swapaxes(1, 2) - on @ inner @ on.swapaxes(1, 2)
        seen = columns @ self.differences.T - on @ (inner @ (spread @ self.differences.T))
        value, vector = np.linalg.eigh(gram)
        squared = (np.einsum("sab,sak->sbk", vector, seen) ** 2).sum(2)[:, :, None]
        noise = 1 + sizes**2 * np.maximum(value, 0.0)[:, :, None]
        gained = squared * sizes**2 / noise - len(self.differences) * np.log(noise)
        return np.asarray(0.5 * gained.sum(1))

    def _white(self, rows: np.ndarray) -> np.ndarray:
        return np.asarray(self.whiten(rows[None])[0])


def repeats(observations: Observations) -> list[Repeats]:
    """Those of every condition that has several trials with traces, at the times that they share."""
    o = observations
    found = []
    for condition in np.unique(o.condition):
        trials = np.flatnonzero((o.condition == condition) & o.traced.any(1))
        if len(trials) < 2:
            continue
        interval = float(o.interval[trials[0]])
        time, force = _together(o, trials)
        if len(time) < FEWEST:
            continue
        mean = force.mean(0)
        by_velocity, by_pretension = o.rel_std[0] * mean, np.full(len(mean), o.rel_std[1] * o.f_p[trials[0]])
        by_trigger = o.trigger_std * interval * np.gradient(mean, time)
        whiten = Whitener(time[None], np.ones((1, len(time)), bool), o.noise)
        contrasts = helmert(len(trials)) @ force
        white = np.asarray(
            whiten(np.concatenate([[by_velocity, by_pretension, by_trigger], contrasts])[None])[0]
        )
        found.append(Repeats(time, float(mean.max()), whiten, white[:3], contrasts, white[3:]))
    return found


def _together(o: Observations, trials: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The times (n,), s, of the first of some trials at which all were read, and the forces there (trials, n), N.

    A recording begins anywhere between two samples of another: what lies between its own is interpolated by a spline.
    """
    read = [(o.time[i][o.used[i]], o.force[i][o.used[i]]) for i in trials]
    if min(len(time) for time, _ in read) < FEWEST:
        return np.zeros(0), np.zeros((len(trials), 0))
    first, reach = read[0][0], (0.5 + SAME) * float(o.interval[trials[0]])
    beside = [_to_nearest(time, first) <= reach for time, _ in read]  # a gap is not bridged
    time = first[np.all(beside, axis=0)]
    return time, np.array([CubicSpline(*own)(time) for own in read])


def _to_nearest(time: np.ndarray, at: np.ndarray) -> np.ndarray:
    """How far each instant is from the nearest of two times and more, both increasing."""
    after = np.clip(np.searchsorted(time, at), 1, len(time) - 1)
    return np.asarray(np.minimum(np.abs(at - time[after - 1]), np.abs(time[after] - at)))


def _inner(spread: np.ndarray) -> np.ndarray:
    return np.asarray(np.eye(len(spread)) + spread @ spread.T)

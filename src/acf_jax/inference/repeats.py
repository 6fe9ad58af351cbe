"""What the repeats of a condition say of scatter: their differences hold nothing that a model predicts."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import helmert

from acf_jax.dataset import Noise
from acf_jax.inference.fit import Fit
from acf_jax.inference.observations import N_NUISANCE, Observations
from acf_jax.inference.ring import Ring, ringing
from acf_jax.inference.whitening import Whitener

SAME = 0.01  # of an interval, by which samples that lie half of one apart may lie farther apart
FEWEST = 3  # samples that repeats have to share: their slope is needed


class Alike(NamedTuple):
    """The trials of one condition at the times that they share, in N."""

    time: np.ndarray  # (n,) s
    largest: float  # force of the mean trace
    by_motion: np.ndarray  # (2, n) by one standard deviation of velocity and pretension
    by_shift: np.ndarray  # (k, n) by a trigger that is one sampling interval late
    contrasts: np.ndarray  # (trials - 1, n) orthonormal: each scatters as a trace does

    def beside(self, noise: Noise) -> "Repeats":
        """In units of independent noise."""
        whiten = Whitener(self.time[None], np.ones((1, len(self.time)), bool), noise)
        rows = np.concatenate([self.by_motion, self.by_shift, self.contrasts])
        white = np.asarray(whiten(rows[None])[0])
        first, last = len(self.by_motion), len(rows) - len(self.contrasts)
        return Repeats(self.time, self.largest, whiten, white[:first], white[first:last], white[last:])


class Repeats(NamedTuple):
    """The same in units of independent noise."""

    time: np.ndarray  # (n,) s
    largest: float  # N
    whiten: Whitener  # of one trial
    by_motion: np.ndarray  # (2, n)
    by_shift: np.ndarray  # (k, n)
    differences: np.ndarray  # (trials - 1, n)

    def spread(self, trigger_std: float, rings: Sequence[Ring]) -> np.ndarray:
        """(k, n) by one standard deviation of all that scatters; `trigger_std`: in sampling intervals."""
        return np.concatenate([self.by_motion, trigger_std * self.by_shift, self.seen(rings)])

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


def alike(observations: Observations, fitted: Fit | None = None) -> list[Alike]:
    """Those of every condition that has several trials with traces.

    A late trigger is seen by the differences of neighbouring samples on either side: a fast trace changes by more than
    its slope. With a fit its prediction of each trial is taken off, at the velocity, pretension and trigger that it
    finds for that; what it leaves that trials share is late with them.
    """
    o = observations
    force, spread = (o.force, None) if fitted is None else _beside(o, fitted)
    largest = np.where(o.used, o.force, 0.0).max(1)
    found = []
    for condition in np.unique(o.condition):
        trials = np.flatnonzero((o.condition == condition) & o.traced.any(1))
        if len(trials) < 2:
            continue
        time, samples, rows = _together(o, trials, force)
        if len(time) < FEWEST:
            continue
        first, mean = trials[0], rows.mean(0)
        steps = np.diff(mean) / np.diff(time) * float(o.interval[first]) / np.sqrt(2)
        by_shift = np.array([np.append(steps, steps[-1]), np.append(steps[0], steps)])
        if spread is None:
            by_motion = np.array([o.rel_std[0] * mean, np.full(len(mean), o.rel_std[1] * o.f_p[first])])
        else:
            by_motion, by_trigger = np.split(spread[first][:, samples], [2])
            by_shift = np.concatenate([by_trigger, by_shift])
        found.append(
            Alike(time, float(largest[trials].mean()), by_motion, by_shift, helmert(len(trials)) @ rows)
        )
    return found


def _beside(o: Observations, fitted: Fit) -> tuple[np.ndarray, np.ndarray]:
    """(trials, n) N, what a fit leaves and what it took for rings; (trials, 3, n) N, what moves its prediction.

    That is one standard deviation of velocity and pretension, and a trigger that is one sampling interval late.
    """
    linear, own = fitted.linearised(), fitted.observations
    rings = slice(own.n_moving, own.n_moving + 2 * len(own.rings))
    ringing = np.einsum("ik,ikn->in", fitted.nuisance[:, rings], own.ringing[:, : 2 * len(own.rings)])
    scale = np.array([1.0, 1.0, own.trigger_std])[:, None]
    return np.where(o.used, o.force - linear.predicted + ringing, 0.0), linear.spread[:, :N_NUISANCE] / scale


def _together(
    o: Observations, trials: np.ndarray, force: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The times (n,), s, of the first of some trials at which all were read, its samples there, and what all have then.

    A recording begins anywhere between two samples of another: what lies between its own is interpolated by a spline.
    """
    read = [(o.time[i][o.used[i]], force[i][o.used[i]]) for i in trials]
    if min(len(time) for time, _ in read) < FEWEST:
        return np.zeros(0), np.zeros(0, int), np.zeros((len(trials), 0))
    first, reach = read[0][0], (0.5 + SAME) * float(o.interval[trials[0]])
    beside = [_to_nearest(time, first) <= reach for time, _ in read]  # a gap is not bridged
    shared = np.all(beside, axis=0)
    time, samples = first[shared], np.flatnonzero(o.used[trials[0]])[shared]
    return time, samples, np.array([CubicSpline(*own)(time) for own in read])


def _to_nearest(time: np.ndarray, at: np.ndarray) -> np.ndarray:
    """How far each instant is from the nearest of two times and more, both increasing."""
    after = np.clip(np.searchsorted(time, at), 1, len(time) - 1)
    return np.asarray(np.minimum(np.abs(at - time[after - 1]), np.abs(time[after] - at)))


def _inner(spread: np.ndarray) -> np.ndarray:
    return np.asarray(np.eye(len(spread)) + spread @ spread.T)

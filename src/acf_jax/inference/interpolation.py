"""Forces between the points of the grid: at measured times, and at their peak."""

from typing import NamedTuple

import numpy as np

AROUND = np.arange(-1, 3)  # the samples about a time, from the one before it
SEEN = 0.02  # of the peak: a sensed force below it means that contact is lost


def first_loss(contact: np.ndarray) -> np.ndarray:
    """Index of the first sample without contact, of contact forces (..., samples); their number where it is held.

    A free curve may begin without force: contact is lost only after there was some.
    """
    held = np.logical_or.accumulate(np.greater(contact, 0), axis=-1)
    is_lost = np.less_equal(contact[..., 1:], 0) & held[..., :-1]
    return np.where(is_lost.any(-1), is_lost.argmax(-1) + 1, contact.shape[-1])


class Taps(NamedTuple):
    """Cubic interpolation on a grid, of values or of their rate."""

    near: np.ndarray  # (4, ..., n) int, the samples on either side
    at: np.ndarray  # (..., n) where between the middle two, from the first of them, in steps

    @property
    def weight(self) -> np.ndarray:
        """(4, ..., n) by which the samples give the value."""
        return _cubic(self.at)

    def rate_weight(self, h: float) -> np.ndarray:
        """(4, ..., n) by which they give its rate per second on a grid of step `h`."""
        a, square = self.at, 3 * self.at**2
        rate = np.empty((4, *a.shape))
        rate[0] = (6 * a - 2 - square) / (6 * h)
        rate[1] = (square - 4 * a - 1) / (2 * h)
        rate[2] = (2 * a + 2 - square) / (2 * h)
        rate[3] = (square - 1) / (6 * h)
        return rate


def taps(times: np.ndarray, h: float, contact: np.ndarray) -> Taps:
    """How to interpolate at `times` (..., n) on a grid of step `h`.

    Times within the first step are reached from behind it: at time 0 a sensor with the least lag reads nothing yet.
    Forces have a kink where contact is lost, by the contact force (..., samples): no interpolation reaches across it.
    """
    at = times / h
    k = _beside_loss(np.clip(at.astype(int), 2, contact.shape[-1] - 3), at, contact)
    return Taps(k + AROUND.reshape(4, *(1,) * k.ndim), at - k)


def _cubic(a: np.ndarray) -> np.ndarray:
    before, after, beyond = a + 1, a - 1, a - 2
    inner, outer = a * after, before * beyond
    weight = np.empty((4, *a.shape))
    np.multiply(inner, beyond / -6, out=weight[0])
    np.multiply(outer, after / 2, out=weight[1])
    np.multiply(outer, a / -2, out=weight[2])
    np.multiply(inner, before / 6, out=weight[3])
    return weight


def _beside_loss(k: np.ndarray, at: np.ndarray, contact: np.ndarray) -> np.ndarray:
    """The indices `k` of times `at`, moved to the side of the first loss of contact on which the time is."""
    lost = first_loss(contact)[..., None]
    before, after = lost - 3, lost + 1
    has_room = (before >= 2) & (after <= contact.shape[-1] - 3)
    if not has_room.any():
        return k
    is_before = at < lost - 1
    within = (at < lost) & ~is_before & has_room  # of the step in which contact is lost
    if within.any():
        before_it = np.where(has_room, before, 2)
        held = np.take_along_axis(contact, before_it + AROUND, -1)[..., None, :]
        reached = np.broadcast_to(held, (*at.shape, 4))[within]
        is_before[within] = (reached * _cubic((at - before_it)[within]).T).sum(-1) > 0
    return np.where(has_room, np.where(is_before, np.minimum(k, before), np.maximum(k, after)), k)


def at_times(values: np.ndarray, times: np.ndarray, h: float, contact: np.ndarray) -> np.ndarray:
    """Values (..., samples) on the grid, at `times` (n,), by the interpolation of `taps`."""
    found = taps(times, h, contact)
    return np.asarray(np.einsum("...kn,kn->...n", values[..., found.near], found.weight))


def combine(values: np.ndarray, near: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Values (trials, rows, samples) at each trial's own times: indices and weights (4, trials, n) are from `taps`."""
    result = np.empty((*values.shape[:2], near.shape[-1]))
    for trial in range(len(values)):  # taken trial by trial: several times as fast as all at once
        taken = values[trial].take(near[:, trial], axis=1)
        np.add.reduce(taken * weight[:, trial], axis=1, out=result[trial])
    return result


def combine_row(values: np.ndarray, near: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """The same for values (trials, samples) of one row."""
    first = values.shape[-1] * np.arange(len(values))
    return np.asarray((values.ravel().take(near + first[:, None]) * weight).sum(0))


def phase_end(sensed: np.ndarray, contact: np.ndarray) -> int:
    """Number of samples of the impact phase: until contact is lost and the sensor, which may lag, has seen it."""
    after = int(first_loss(contact)) + 1
    if after > len(sensed):
        return len(sensed)
    seen = np.flatnonzero(sensed[after - 1 :] <= SEEN * sensed.max())
    return after + int(seen[0]) if seen.size else len(sensed)


def peak_of(sensed: np.ndarray, h: float, contact: np.ndarray) -> tuple[float, float]:
    """Largest sensed force within the impact phase, refined by a parabola: force in N, time in s."""
    end = phase_end(sensed, contact)
    k = int(np.argmax(sensed[:end]))
    if 0 < k < end - 1:
        left, mid, right = sensed[k - 1 : k + 2]
        curvature = left - 2 * mid + right
        if curvature < 0:
            shift = 0.5 * (left - right) / curvature
            return float(mid - 0.25 * (left - right) * shift), (k + shift) * h
    return float(sensed[k]), k * h

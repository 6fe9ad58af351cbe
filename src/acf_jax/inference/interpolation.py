"""Forces between the points of the grid: at measured times, and at their peak."""

import numpy as np

SEEN = 0.02  # of the peak: a sensed force below it means that contact is lost


def first_loss(contact: np.ndarray) -> np.ndarray:
    """Index of the first sample without contact, of contact forces (..., samples); their number where it is held.

    A free curve may begin without force: contact is lost only after there was some.
    """
    held = np.logical_or.accumulate(np.greater(contact, 0), axis=-1)
    is_lost = np.less_equal(contact[..., 1:], 0) & held[..., :-1]
    return np.where(is_lost.any(-1), is_lost.argmax(-1) + 1, contact.shape[-1])


def taps(times: np.ndarray, h: float, contact: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cubic interpolation at `times` (..., n): indices (4, ..., n) on the grid, weights of the value and of its rate.

    Times within the first step are reached from behind it: at time 0 a sensor with the least lag reads nothing yet.
    Forces have a kink where contact is lost, by the contact force (..., samples): no interpolation reaches across it.
    """
    at = times / h
    k = _beside_loss(np.clip(at.astype(int), 2, contact.shape[-1] - 3), at, contact)
    a = at - k
    rate = np.stack(
        [
            -(3 * a**2 - 6 * a + 2) / 6,
            (3 * a**2 - 4 * a - 1) / 2,
            -(3 * a**2 - 2 * a - 2) / 2,
            (3 * a**2 - 1) / 6,
        ]
    )
    return _around(k), _cubic(a), rate / h


def _around(k: np.ndarray) -> np.ndarray:
    return np.stack([k - 1, k, k + 1, k + 2])


def _cubic(a: np.ndarray) -> np.ndarray:
    return np.stack(
        [
            -a * (a - 1) * (a - 2) / 6,
            (a + 1) * (a - 1) * (a - 2) / 2,
            -(a + 1) * a * (a - 2) / 2,
            (a + 1) * a * (a - 1) / 6,
        ]
    )


def _beside_loss(k: np.ndarray, at: np.ndarray, contact: np.ndarray) -> np.ndarray:
    """The indices `k` of times `at`, moved to the side of the first loss of contact on which the time is."""
    lost = first_loss(contact)[..., None]
    before, after = lost - 3, lost + 1
    has_room = (before >= 2) & (after <= contact.shape[-1] - 3)
    if not has_room.any():
        return k
    before = np.broadcast_to(np.where(has_room, before, 2), k.shape)
    left = (np.take_along_axis(contact[None], _around(before), -1) * _cubic(at - before)).sum(0)
    is_before = (at < lost - 1) | ((at < lost) & (left > 0))
    return np.where(has_room, np.where(is_before, np.minimum(k, before), np.maximum(k, after)), k)


def at_times(values: np.ndarray, times: np.ndarray, h: float, contact: np.ndarray) -> np.ndarray:
    """Values (..., samples) on the grid, at `times` (n,), by the interpolation of `taps`."""
    near, weight, _ = taps(times, h, contact)
    return np.asarray(np.einsum("...kn,kn->...n", values[..., near], weight))


def combine(values: np.ndarray, near: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Values (trials, rows, samples) at each trial's own times: indices and weights (4, trials, n) are from `taps`."""
    result = np.empty((*values.shape[:2], near.shape[-1]))
    for trial in range(len(values)):  # taken trial by trial: several times as fast as all at once
        taken = values[trial].take(near[:, trial], axis=1)
        np.add.reduce(taken * weight[:, trial], axis=1, out=result[trial])
    return result


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

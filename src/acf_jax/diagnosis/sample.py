"""Forces between the points of the grid: at measured times, and at their peak."""

import numpy as np

SEEN = 0.02  # of the peak: a sensed force below it means that contact is lost


def taps(times: np.ndarray, h: float, samples: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cubic interpolation at `times` (...): indices (4, ...) on the grid, weights of the value and of its rate.

    Times within the first step are reached from behind it: at time 0 a sensor with the least lag reads nothing yet.
    """
    k = np.clip((times / h).astype(int), 2, samples - 3)
    a = times / h - k
    value = np.stack(
        [
            -a * (a - 1) * (a - 2) / 6,
            (a + 1) * (a - 1) * (a - 2) / 2,
            -(a + 1) * a * (a - 2) / 2,
            (a + 1) * a * (a - 1) / 6,
        ]
    )
    rate = np.stack(
        [
            -(3 * a**2 - 6 * a + 2) / 6,
            (3 * a**2 - 4 * a - 1) / 2,
            -(3 * a**2 - 2 * a - 2) / 2,
            (3 * a**2 - 1) / 6,
        ]
    )
    return np.stack([k - 1, k, k + 1, k + 2]), value, rate / h


def at_times(values: np.ndarray, times: np.ndarray, h: float) -> np.ndarray:
    """Values (..., samples) on the grid, at `times` (n,), by cubic interpolation."""
    near, weight, _ = taps(times, h, values.shape[-1])
    return np.asarray(np.einsum("...kn,kn->...n", values[..., near], weight))


def combine(values: np.ndarray, near: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Values (trials, rows, samples) at each trial's own times: indices and weights (4, trials, n) are from `taps`."""
    result = np.zeros((*values.shape[:2], near.shape[-1]))
    for k, w in zip(near, weight, strict=True):
        result += np.take_along_axis(values, k[:, None], axis=2) * w[:, None]
    return result


def phase_end(sensed: np.ndarray, contact: np.ndarray) -> int:
    """Number of samples of the impact phase: until contact is lost and the sensor, which may lag, has seen it."""
    lost = np.flatnonzero(contact[1:] <= 0)
    if not lost.size:
        return len(sensed)
    after = int(lost[0]) + 2
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

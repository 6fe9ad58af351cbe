"""The onset of one contact: what the sensor read before, and between which samples the part was touched."""

import numpy as np

from acf_jax.recording.level import DEBOUNCE
from acf_jax.recording.series import Array

LEAST_APPROACH = 20  # samples, as a data set wants
_OBVIOUS = 30.0  # standard deviations of the noise at which an onset needs no more samples
_SAME = 3.0  # standard deviations of the noise that one level may seem to move


def rest_of(samples: Array) -> tuple[float, float]:
    """Level and noise of an approach; of its later half, and so on, where the earlier one is at another level."""
    if samples.size == 0:
        return 0.0, 0.0
    while samples.size >= 2 * LEAST_APPROACH:
        half = samples.size // 2
        (early, noise), (late, other) = _centre(samples[:half]), _centre(samples[half:])
        if abs(late - early) <= _SAME * min(noise, other):
            break
        samples = samples[half:]
    return _centre(samples)


def onset_at(
    force: Array, approach: int, crossing: int, stop: int, offset: float, noise: float
) -> tuple[int, float]:
    """Index of the first sample in contact, and by which share of a sample contact came before it.

    A force that jumps was touched anywhere in the last interval: half of it. One that climbs from the offset
    began where the line meets it.
    """
    scale = max(noise, 1e-9 * max(abs(offset), 1.0))
    # a slow climb needs more samples than a jump to stand out of the noise
    clear = np.argmax(force[crossing : crossing + 4 * DEBOUNCE] > offset + _OBVIOUS * scale)
    end = min(crossing + max(int(clear), DEBOUNCE + 1), stop)
    begin = max(approach, crossing - 10 * DEBOUNCE)
    rest = (force[begin:end] - offset) / scale
    quiet = np.r_[0.0, np.cumsum(rest**2)]
    losses, slopes, heights = [], [], []
    for k in range(crossing - begin + 1):
        x = np.arange(rest.size - k, dtype=float)
        fit = np.polynomial.polynomial.polyfit(x, rest[k:], min(2, x.size - 1))
        losses.append(quiet[k] + float(((np.polynomial.polynomial.polyval(x, fit) - rest[k:]) ** 2).sum()))
        heights.append(float(fit[0]))
        slopes.append(float(fit[1]) if fit.size > 1 else 0.0)
    best = int(np.argmin(losses))
    share = heights[best] / slopes[best] if slopes[best] > 0.0 else np.inf
    return begin + best, float(np.clip(share, 0.0, 1.0)) if share <= 1.0 else 0.5


def _centre(samples: Array) -> tuple[float, float]:
    """Median, and the standard deviation about it that a few odd samples do not change."""
    middle = float(np.median(samples))
    spread = 1.4826 * float(np.median(np.abs(samples - middle)))
    return middle, spread if spread > 0.0 else float(samples.std())

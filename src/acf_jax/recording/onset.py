"""The onset of one contact: what the sensor read before, and between which samples the part was touched."""

import numpy as np

from acf_jax.dataset.noise import robust_std
from acf_jax.recording.level import DEBOUNCE
from acf_jax.recording.series import Array

LEAST_APPROACH = 20  # samples, as a data set wants
SURE = LEAST_APPROACH - 4  # of them that surely lie before contact
_OBVIOUS = 30.0  # standard deviations of the noise at which an onset needs no more samples
_CANDIDATES = 60  # onsets that are compared at first; then those between the best and its neighbours
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
    begin = max(approach, _last_quiet(force[approach:crossing], offset + scale) + approach - 10 * DEBOUNCE)
    rest = (force[begin:end] - offset) / scale
    quiet = np.r_[0.0, np.cumsum(rest**2)]

    def climb(k: int) -> tuple[float, float, float]:
        """Misfit of rest before sample k and a parabola from there on; the parabola's height and slope at k.

        Where it would bend upwards a line takes its place: a parabola that does begins anywhere within the rest.
        """
        x = np.arange(rest.size - k, dtype=float)
        fit = np.polynomial.polynomial.polyfit(x, rest[k:], min(2, x.size - 1))
        if fit.size > 2 and fit[2] > 0.0:
            fit = np.polynomial.polynomial.polyfit(x, rest[k:], 1)
        loss = quiet[k] + float(((np.polynomial.polynomial.polyval(x, fit) - rest[k:]) ** 2).sum())
        return loss, float(fit[0]), float(fit[1]) if fit.size > 1 else 0.0

    count = crossing - begin + 1
    stride = -(-count // _CANDIDATES)
    best = min(range(0, count, stride), key=lambda k: climb(k)[0])
    best = min(range(max(best - stride, 0), min(best + stride + 1, count)), key=lambda k: climb(k)[0])
    _, height, slope = climb(best)
    share = height / slope if slope > 0.0 else np.inf
    return begin + best, float(np.clip(share, 0.0, 1.0)) if share <= 1.0 else 0.5


def _last_quiet(samples: Array, limit: float) -> int:
    """Index of the last sample about which the mean of a few is at most `limit`; 0 if there is none."""
    width = 2 * DEBOUNCE + 1
    if samples.size < width:
        return 0
    low = np.flatnonzero(np.convolve(samples, np.full(width, 1.0 / width), "valid") <= limit)
    return int(low[-1]) + DEBOUNCE if low.size else 0


def _centre(samples: Array) -> tuple[float, float]:
    """Median, and the standard deviation about it that a few odd samples do not change."""
    middle = float(np.median(samples))
    spread = robust_std(samples - middle)
    return middle, spread if spread > 0.0 else float(samples.std())

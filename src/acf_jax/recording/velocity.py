"""The contact velocity, and the pretension, at one contact.

The speed just before contact is a straight line, or a constant, through the samples of the last fraction of a second;
a position gets a polynomial of one degree more, and its derivative at contact (the filter of Savitzky and Golay, 'Anal.
Chem.' 36 (1964) 1627, at the end of its window and for uneven times). Of several windows and degrees the one with the
smallest standard deviation counts: where the robot still accelerates a long window misfits, and its residuals say so.
"""

from dataclasses import dataclass

import numpy as np

from acf_jax.recording.series import Array, Series

WINDOWS = (0.4, 0.2, 0.1, 0.05, 0.025)  # s before contact
LEAST = 8  # samples of a window, where a longer one has more
FLOOR = 1e-3  # relative standard deviation: nobody's clock and scale are known better
_LONE = 0.05  # relative standard deviation of a single sample
_PRETENSION = 0.1  # s before contact


@dataclass(frozen=True)
class Estimate:
    """A value with its standard deviation."""

    value: float
    std: float


def velocity_at(series: Series, is_position: bool, begin: int) -> Estimate | None:
    """The velocity, m/s, at the time `begin` (ns) from the samples before it; None where there are too few."""
    longest = series.between(begin - round(1e9 * WINDOWS[0]), begin)
    time, value = _fresh(longest.seconds(begin), longest.value)
    least = 3 if is_position else 1
    if time.size < least:
        return None
    found = []
    for window in WINDOWS:
        inside = time >= -window
        count = int(np.count_nonzero(inside))
        if count < min(LEAST, time.size):
            break
        for degree in (1, 2) if is_position else (0, 1):
            if count > degree + 1:
                found.append(_fit(time[inside], value[inside], degree, is_position))
    if not found:
        return Estimate(float(value[-1]), max(_LONE * abs(float(value[-1])), float(np.ptp(value))))
    best = min(found, key=lambda estimate: estimate.std)
    return Estimate(best.value, float(np.hypot(best.std, FLOOR * best.value)))


def pretension_at(series: Series, begin: int) -> Estimate | None:
    """The pretension, N, that was set before the time `begin` (ns); None where nothing had been recorded."""
    before = series.between(begin - round(1e9 * _PRETENSION), begin).value
    if before.size == 0:
        last = int(np.searchsorted(series.time, begin)) - 1
        return Estimate(float(series.value[last]), 0.0) if last >= 0 else None
    return Estimate(float(np.median(before)), float(before.std() / before.size**0.5))


def _fresh(time: Array, value: Array) -> tuple[Array, Array]:
    """The samples without those that only repeat a held value: one is kept for each usual time between changes.

    What stays the same for longer than that was measured more than once.
    """
    changes = np.flatnonzero(np.diff(value)) + 1
    if changes.size < 2 or changes.size > 0.7 * value.size:
        return time, value
    runs = np.r_[0, changes, value.size]
    held = np.arange(value.size) - np.repeat(runs[:-1], np.diff(runs))
    kept = held % max(round(float(np.median(np.diff(changes)))), 1) == 0
    return time[kept], value[kept]


def _fit(time: Array, value: Array, degree: int, is_position: bool) -> Estimate:
    """Least squares of a polynomial; its value (of a position: its slope) at time 0, where contact is."""
    width = max(-float(time[0]), 1e-9)
    columns = np.vander(time / width, degree + 1, increasing=True)
    inverse = np.linalg.pinv(columns)
    coefficients = inverse @ value
    rest = value - columns @ coefficients
    at = 1 if is_position else 0
    free = time.size - degree - 1
    variance = float(rest @ rest) / free
    scatter = float(rest @ rest)
    lag_one = float(np.clip(rest[1:] @ rest[:-1] / scatter, 0.0, 0.95)) if scatter > 0.0 else 0.0
    # residuals that resemble their neighbours count as fewer, and few of them say little about their own size
    inflation = (1.0 + lag_one) / (1.0 - lag_one) * (free / (free - 2.0) if free > 2 else 9.0)
    std = float(np.sqrt(variance * inflation * (inverse[at] @ inverse[at])))
    scale = width if is_position else 1.0
    return Estimate(float(coefficients[at]) / scale, std / scale)

"""The contact velocity, and the pretension, at one contact.

The speed just before contact is a straight line, or a constant, through the samples of the last fraction of a second;
a position gets a polynomial of one degree more, and its derivative at contact (the filter of Savitzky and Golay, 'Anal.
Chem.' 36 (1964) 1627, at the end of its window and for uneven times). Of several windows and degrees the one with the
smallest standard deviation counts: where the robot still accelerates a long window misfits, and its residuals say so.

A speed as it was commanded rather than measured is a few values that come again and again, exactly: the last one is it.
"""

from dataclasses import dataclass

import numpy as np

from acf_jax.dataset.noise import robust_std
from acf_jax.dataset.trials import RobotVelocity
from acf_jax.recording.series import Array, Series

WINDOWS = (0.4, 0.2, 0.1, 0.05, 0.025)  # s before contact
LEAST = 8  # samples of a window, where a longer one has more
_FEW = 5  # the same where the noise of a sample is known from the whole recording
FLOOR = 1e-3  # relative standard deviation: nobody's clock and scale are known better
_LONE = 0.05  # relative standard deviation of a single sample
_MOVES = 0.1  # of the largest speed, from which on a robot moves
_STEADY = 3  # new values that are the same: no part of a ramp, and hardly chance
_PRETENSION = 0.1  # s before contact
_MOTION = 0.05  # s before contact, of the robot's motion: tells the scatter of its velocity


@dataclass(frozen=True)
class Estimate:
    """A value with its standard deviation."""

    value: float
    std: float


@dataclass(frozen=True)
class Character:
    """What the whole of a speed or position says of its samples."""

    noise_std: float = 0.0  # m/s or m, of one sample; 0: not known
    steady: float = np.inf  # s, how long a speed has to be the same before it is known exactly


def character_of(series: Series, is_position: bool) -> Character:
    """The noise of a robot's signal, and whether it is a speed as it was commanded, without any.

    Such a speed steps to values that come again exactly, or most of its values repeat the one before. A value that a
    faster log only holds until the next one counts once.
    """
    changes = np.flatnonzero(np.diff(series.value)) + 1
    if changes.size < 2:
        return Character(steady=np.inf if is_position else 0.0)
    time = series.seconds(int(series.time[0]))
    fresh, value = _fresh(time, series.value)
    if not is_position:
        steps = series.value[np.r_[0, changes]]
        comes_again = np.unique(steps).size <= 0.5 * steps.size + 1
        if comes_again and np.median(np.diff(time[changes])) > WINDOWS[0] / LEAST:  # too long to be held
            return Character(steady=_STEADY * float(np.median(np.diff(time))))
        if np.mean(np.diff(value) == 0.0) > 0.5:
            return Character(steady=_STEADY * float(np.median(np.diff(fresh))))
    moves = slice(None) if is_position else np.abs(value[1:-1]) > _MOVES * float(np.abs(value).max())
    bend = np.diff(value, 2)[moves]
    return Character(noise_std=robust_std(bend) / 6.0**0.5 if bend.size else 0.0)


def velocity_at(
    series: Series, is_position: bool, begin: int, character: Character | None = None
) -> Estimate | None:
    """The velocity, m/s, at the time `begin` (ns) from the samples before it; None where there are too few."""
    character = character or Character()
    longest = series.between(begin - round(1e9 * WINDOWS[0]), begin)
    if (last := longest.value[-1:]).size:
        changes = np.flatnonzero(longest.value != last)
        since = longest.time[changes[-1] + 1 if changes.size else 0]
        if 1e-9 * (begin - since) >= character.steady:
            return Estimate(float(last[0]), FLOOR * abs(float(last[0])))
    time, value = _fresh(longest.seconds(begin), longest.value)
    enough = 3 if is_position else 1
    if time.size < enough:
        return None
    least = min(LEAST if character.noise_std == 0.0 else _FEW, time.size)
    found = []
    for window in WINDOWS:
        inside = time >= -window
        count = int(np.count_nonzero(inside))
        if count < least:
            break
        noise = character.noise_std if count < LEAST else 0.0
        for degree in (1, 2) if is_position else (0, 1):
            if count > degree + 1:
                found.append(_fit(time[inside], value[inside], degree, is_position, noise))
    if not found:
        return Estimate(float(value[-1]), max(_LONE * abs(float(value[-1])), float(np.ptp(value))))
    best = min(found, key=lambda estimate: estimate.std)
    return Estimate(best.value, float(np.hypot(best.std, FLOOR * best.value)))


def motion_over(series: Series, begin: int, until: float) -> RobotVelocity | None:
    """The measured velocities about the time `begin` (ns) and until the first one `until` s later.

    **Returns:** over s since `begin`, without samples that only repeat a held value; None where there are too few.
    """
    first, last = np.searchsorted(series.time, (begin - round(1e9 * _MOTION), begin + round(1e9 * until)))
    part = series.at(slice(int(first), int(last) + 1))
    time, value = _fresh(part.seconds(begin), part.value)
    return (
        RobotVelocity(time, value) if np.count_nonzero(time < 0.0) >= _FEW and time.size > 2 * _FEW else None
    )


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


def _fit(time: Array, value: Array, degree: int, is_position: bool, noise: float) -> Estimate:
    """Least squares of a polynomial; its value (of a position: its slope) at time 0, where contact is.

    Few residuals may be small by chance: `noise` is the standard deviation of a sample that they do not undercut.
    """
    width = max(-float(time[0]), 1e-9)
    columns = np.vander(time / width, degree + 1, increasing=True)
    inverse = np.linalg.pinv(columns)
    coefficients = inverse @ value
    rest = value - columns @ coefficients
    at = 1 if is_position else 0
    free = time.size - degree - 1
    variance = max(float(rest @ rest) / free, noise**2)
    scatter = float(rest @ rest)
    lag_one = float(np.clip(rest[1:] @ rest[:-1] / scatter, 0.0, 0.95)) if scatter > 0.0 else 0.0
    # residuals that resemble their neighbours count as fewer, and few of them say little about their own size
    inflation = (1.0 + lag_one) / (1.0 - lag_one) * (free / (free - 2.0) if free > 2 else 9.0)
    std = float(np.sqrt(variance * inflation * (inverse[at] @ inverse[at])))
    scale = width if is_position else 1.0
    return Estimate(float(coefficients[at]) / scale, std / scale)

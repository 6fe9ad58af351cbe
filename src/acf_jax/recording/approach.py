"""How far a robot has come over time, and where its approaches end."""

from dataclasses import dataclass, replace

import numpy as np

from acf_jax.recording.series import Array, Series

_WIDTH = 0.05, 2.0  # s, and samples at least, that speeds before and after a time are means of
_FINE = 50  # steps in that time, to find where an approach ends
_SHORT = 0.1, 2.0  # of it, and samples at least, for the speed at a time


@dataclass(frozen=True)
class Travel:
    """The position of a robot, or the integral of its speed, between its samples."""

    time: Array  # s, shape (N,)
    place: Array  # m, shape (N,)
    step: float  # s, sampling interval
    width: float  # s

    def turned(self) -> "Travel":
        """The same the other way."""
        return replace(self, place=-self.place)

    def speed(self, begin: Array, end: Array) -> Array:
        """The mean speed between two times, m/s."""
        way = np.interp(end, self.time, self.place) - np.interp(begin, self.time, self.place)
        return np.asarray(way / (end - begin))

    def ends(self, time: Array, slowest: float) -> Array:
        """By which share of its speed an approach ends at `time`, 0 to 1; 0 where that is below `slowest`, m/s."""
        before = self.speed(time - self.width, time)
        drop = before - self.speed(time, time + self.width)
        approach = np.maximum(before, self.speed(time - 2.0 * self.width, time - self.width))
        share = np.minimum(before, drop) / np.maximum(approach, slowest)
        is_known = (time - 2.0 * self.width >= self.time[0]) & (time + self.width <= self.time[-1])
        return np.where(is_known & (approach > slowest), np.clip(share, 0.0, 1.0), 0.0)

    def slowdowns(self, near: Array) -> Array:
        """When the robot begins to slow down about each time, s; NaN where it does not."""
        return np.array([self._slowdown(float(time)) for time in near])

    def _slowdown(self, near: float) -> float:
        around = np.linspace(-self.width, self.width, 2 * _FINE + 1)
        before, after = (
            (near + around - self.width, near + around),
            (near + around, near + around + self.width),
        )
        middle = near + float(around[np.argmax(self.speed(*before) - self.speed(*after))])
        level = float(self.speed(np.array(middle - 2.0 * self.width), np.array(middle - 0.5 * self.width)))
        short = max(_SHORT[0] * self.width, _SHORT[1] * self.step)
        times = middle + around
        speed = self.speed(times - 0.5 * short, times + 0.5 * short)
        fast = np.flatnonzero(speed[: _FINE + 1] >= 0.9 * level)
        if level <= 0.0 or fast.size == 0:
            return np.nan
        last = int(fast[-1])
        half, slow = (
            last + int(np.argmax(np.append(speed[last:-1] < share * level, True))) for share in (0.5, 0.1)
        )
        # a mean over a short time makes a ramp of a step; what is longer the robot takes to slow down
        ramp = max((times[slow] - times[last]) / 0.8 - short, 0.0)
        return float(times[half] - 0.5 * ramp)


def travel_of(series: Series, is_position: bool) -> Travel:
    """The way of a robot from its position, m, or its speed, m/s."""
    time = series.seconds(0)
    steps = np.diff(time)
    step = float(np.median(steps)) if steps.size else 0.0
    place = series.value
    if not is_position:
        place = np.r_[0.0, np.cumsum(0.5 * (place[1:] + place[:-1]) * steps)]
    return Travel(time, place, step, max(_WIDTH[0], _WIDTH[1] * step))

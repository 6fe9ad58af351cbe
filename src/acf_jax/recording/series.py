"""Samples of one signal as they come out of a recording, times exact to the nanosecond."""

from array import array
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from acf_jax.errors import InputError

Array = NDArray[np.float64]
Nanoseconds = NDArray[np.int64]

# Told how far reading has come: done and total, in units of the reader's own; a total of 0 is not known.
Progress = Callable[[int, int], None]

_LARGEST = 1e12  # of a force, a speed or a position; what is beyond was never measured
_ROW = 8  # times in a row that several samples have; a clock that ticks a little slower than samples come repeats fewer
_SAME = 0.01  # of a step, within which two times are one
_TOGETHER = 32  # steps whose mean neither jitter nor packets change
_DISORDER = 0.01  # share of samples that may be out of order or not a number before a signal is refused


@dataclass(frozen=True)
class Channel:
    """A topic or column that a recording offers."""

    name: str
    type: str
    count: int | None = None


@dataclass(frozen=True)
class Series:
    """Values over time; `received` holds the recorder's own times where a message brings a stamp besides."""

    time: Nanoseconds  # ns, shape (N,)
    value: Array  # SI units, shape (N,)
    received: Nanoseconds | None = None  # ns, shape (N,)
    notes: tuple[str, ...] = ()  # what a reader of the result should know

    def seconds(self, begin: int) -> Array:
        """Times since `begin` (ns), s, shape (N,)."""
        return np.asarray((self.time - begin) * 1e-9, float)

    def between(self, begin: int, end: int) -> "Series":
        """The samples with begin <= time < end, ns."""
        return self.at(slice(*np.searchsorted(self.time, (begin, end))))

    def at(self, index: NDArray[np.intp] | slice, *notes: str) -> "Series":
        """The samples at `index`, with further notes."""
        received = None if self.received is None else self.received[index]
        return Series(self.time[index], self.value[index], received, (*self.notes, *notes))


@dataclass
class Growing:
    """Samples while they are read, 8 bytes a number."""

    time: "array[int]" = field(default_factory=lambda: array("q"))
    value: "array[float]" = field(default_factory=lambda: array("d"))
    received: "array[int]" = field(default_factory=lambda: array("q"))

    def done(self) -> Series:
        """The samples as arrays over the same memory."""
        received = np.frombuffer(self.received, np.int64) if self.received else None
        return Series(np.frombuffer(self.time, np.int64), np.frombuffer(self.value, np.float64), received)


def in_order(series: Series, where: str) -> Series:
    """The samples that are finite, with increasing times; a few others are left out and noted.

    **Raises:** `InputError` when nothing is left, when more than 1 % would have to go, or when time was set back.
    """
    n = series.time.size
    if n == 0:
        raise InputError(f"{where}: holds no samples; name another signal, or record again")
    sound = np.abs(series.value) < _LARGEST  # not a number is not
    bad = n - int(np.count_nonzero(sound))
    if bad > _DISORDER * n:
        raise InputError(f"{where}: {bad} of {n} values are not finite numbers; correct the recording")
    if bad:
        note = f"{where}: {bad} of {n} values are not finite numbers and are left out"
        series = series.at(np.flatnonzero(sound), note)
    steps = np.diff(series.time)
    if (steps > 0).all():
        return series
    late = int(np.count_nonzero(steps < 0))
    behind = int(np.count_nonzero(series.time < np.maximum.accumulate(series.time)))
    is_back = is_set_back(series.time)
    if is_back or behind > _DISORDER * n:
        why = (
            "its stamps jitter: name the times at which it was recorded"
            if not is_back and _DISORDER * n < late < 0.5 * n
            else f"by up to {-1e-9 * steps.min():.4g} s, before sample {int(steps.argmin()) + 2}: the clock was reset"
            " or recordings are strung together: cut the recording there"
        )
        raise InputError(f"{where}: time steps back {late} times in {n} samples; {why}")
    order = np.argsort(series.time, kind="stable")
    order = order[np.diff(series.time[order], prepend=series.time[order[0]] - 1) > 0]
    gone = series.time.size - order.size
    if gone > 0.5 * n or _repeats_a_stretch(series.time):
        raise InputError(
            f"{where}: {gone} of {n} samples repeat the time of another: the clock was set back, is coarse or stamps"
            " whole packets, or two publishers send at once; name times of more digits, or cut the recording there"
        )
    what = f"{late} samples came late and were put in order" if late else ""
    what += " and " if late and gone else ""
    what += f"{gone} samples repeat a time and are left out" if gone else ""
    return series.at(order, f"{where}: {what}")


def _repeats_a_stretch(time: Nanoseconds) -> bool:
    """Whether several samples have one time, or nearly, and that for many times in a row."""
    ordered = np.sort(time)
    starts = np.r_[0, 1 + np.flatnonzero(ordered[1:] - ordered[:-1] > _SAME * usual_step(time))]
    edges = np.flatnonzero(np.diff(np.diff(starts, append=time.size) > 1, prepend=False, append=False))
    return edges.size > 0 and float(np.mean(edges[1::2] - edges[::2])) >= _ROW


def is_set_back(time: Nanoseconds) -> bool:
    """Whether times that step back begin a second stretch over the first; else samples only came late.

    What comes late fills a gap, or jitters by less than the steps around it; a second stretch is twice as dense.
    """
    back = np.flatnonzero(np.diff(time) < 0) + 1
    if back.size == 0:
        return False
    ordered = np.sort(time)
    begin, end = time[back], np.maximum.accumulate(time)[back - 1]
    count = np.searchsorted(ordered, end, "right") - np.searchsorted(ordered, begin)
    room = (end - begin) / max(usual_step(time), 1.0) + 1.0
    return bool((count > 1.5 * room + 2.0).any())  # two: chance


def usual_step(time: Nanoseconds) -> float:
    """The usual time between two of at least two samples, ns: of many at once."""
    many = min(_TOGETHER, time.size - 1)
    return float(np.median(np.abs(time[many:] - time[:-many]))) / many

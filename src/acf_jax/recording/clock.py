"""Signals stamped by different clocks, brought to one.

A stamp s that reaches the recorder at r has r - s = offset + delay, delay >= 0: the least of many differences
is the clock's offset and the shortest delay. Its course over the recording is the drift between the clocks. By how
much the other delays exceed the shortest tells which offset is worth a correction.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from acf_jax.recording.series import Array, Nanoseconds, Series

LEAST_SHIFT = 2e-3  # s; a velocity at contact does not feel less
_DELAY = 0.1  # s; what is less may be a delay on the way rather than a clock
_CLEAR = 5.0  # times the usual excess of a delay over the shortest
_BLOCKS = 32
_LEAST_BLOCK = 8  # samples
_FRESH = 0.9  # share of the stamps that differ where a clock is set and runs
_LASTING = 3  # blocks at an end of the recording that lie late: more than a recorder that started slowly


@dataclass(frozen=True)
class _Line:
    """Recorder's time minus stamp over the recorder's time, by the shortest delays."""

    origin: int  # ns
    start: float  # s, at the origin
    slope: float  # s/s
    scatter: float  # s, usual excess of a delay over the shortest
    rest: Array  # s, of the shortest delay of each block from the line

    def at(self, received: Nanoseconds) -> Array:
        """The difference at the recorder's times `received`, s."""
        return np.asarray(self.start + self.slope * (received - self.origin) * 1e-9, float)

    @property
    def limit(self) -> float:
        """What is more than the scatter of delays, s."""
        return max(LEAST_SHIFT, _CLEAR * self.scatter)

    @property
    def step(self) -> float:
        """How far stamps leave the line, s; 0 where they keep to it. A recorder that is late for a while is no step."""
        lasting = max(self.rest[:_LASTING].min(), self.rest[-_LASTING:].min())
        leaves = max(-float(self.rest.min()), float(lasting)) > self.limit
        return float(np.ptp(self.rest)) if leaves else 0.0


_NO_LINE = _Line(0, 0.0, 0.0, 0.0, np.zeros(1))


def settle(series: Series, where: str) -> Series:
    """`series` in the order of its stamps where they can be trusted, else by the recorder's times."""
    if series.received is None or series.time.size == 0:
        return series
    increasing = (np.diff(series.time) > 0).all()
    ordered = series if increasing else series.at(np.argsort(series.time, kind="stable"))
    fresh = 1 + np.count_nonzero(np.diff(ordered.time))
    if ordered.time[0] <= 0 or fresh < _FRESH * ordered.time.size:
        why = "its stamps are unset or stand still"
    elif step := _line(series).step:
        why = f"its clock was set while recording, its stamps step by {step:.3g} s"
    else:
        return ordered
    note = f"{where}: {why}; the times at which it was recorded are used"
    return replace(series, time=series.received, received=None, notes=(*series.notes, note))


def to_clock_of(series: Series, force: Series, where: str) -> Series:
    """`series` on the clock of the force: shifted, and noted, where the two clocks are clearly not one."""
    own, other = _line(series), _line(force)
    received = series.time if series.received is None else series.received
    shift = own.at(received) - other.at(received)
    if shift.size == 0 or np.abs(shift).max() < max(own.limit, other.limit):
        return series
    middle, drift = float(np.median(shift)), float(shift[-1] - shift[0])
    note = f"{where}: its clock is {abs(middle):.6g} s {'behind' if middle > 0 else 'ahead of'} that of the force"
    note += f" and drifts by {1e3 * drift:+.3g} ms" if abs(drift) > 1e-3 else ""
    note += "; shifted by the recorder's times"
    note += ", unless clock_offset_s is stated" if np.abs(shift).max() < _DELAY else ""
    moved = series.time + np.rint(1e9 * shift).astype(np.int64)
    return replace(series, time=moved, notes=(*series.notes, note))


def _line(series: Series) -> _Line:
    """The line through the shortest delays; Theil and Sen's slope, which a late recorder does not bend."""
    received = series.received
    if received is None or received.size == 0:
        return _NO_LINE
    origin = int(received[0])
    count = min(_BLOCKS, max(received.size // _LEAST_BLOCK, 1))
    edges = np.linspace(0, received.size, count + 1).astype(int)
    blocks = [slice(a, b) for a, b in pairwise(edges.tolist())]

    def above(slope: float, block: slice) -> Array:
        now = received[block]
        return np.asarray((now - series.time[block]) * 1e-9 - slope * ((now - origin) * 1e-9))

    least = [block.start + int(np.argmin(above(0.0, block))) for block in blocks]
    slope = _slope(received[least] - origin, received[least] - series.time[least])
    shortest = np.array([above(slope, block).min() for block in blocks])
    excess = [
        float(np.median(above(slope, block))) - low for block, low in zip(blocks, shortest, strict=True)
    ]
    start = float(np.median(shortest)) if slope else float(shortest.min())
    return _Line(origin, start, slope, float(np.median(excess)), shortest - np.median(shortest))


def _slope(x: Nanoseconds, y: Nanoseconds) -> float:
    """Theil and Sen's slope of y over x; 0 where the scatter about it hides it."""
    if x.size < 4 or not np.ptp(x):
        return 0.0
    i, j = np.triu_indices(x.size, 1)
    apart = x[i] != x[j]
    slope = float(np.median((y[j] - y[i])[apart] / (x[j] - x[i])[apart]))
    rest = y - slope * x
    spread = float(np.median(np.abs(rest - np.median(rest))))
    return slope if abs(slope) * float(np.ptp(x)) > _CLEAR * spread else 0.0

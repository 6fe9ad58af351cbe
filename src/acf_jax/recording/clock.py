"""Signals stamped by different clocks, brought to one.

A stamp s that reaches the recorder at r has r - s = offset + delay, delay >= 0: the least of many differences
is the clock's offset and the shortest delay. Its course over the recording is the drift between the clocks. By how
much the other delays exceed the shortest tells which offset is worth a correction.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from acf_jax.errors import InputError
from acf_jax.recording.series import Array, Nanoseconds, Series, is_set_back, usual_step

LEAST_SHIFT = 2e-3  # s; a velocity at contact does not feel less
_DELAY = 0.1  # s; what is less may be a delay on the way rather than a clock
_CLEAR = 5.0  # times the usual excess of a delay over the shortest
_BLOCKS = 32
_LEAST_BLOCK = 8  # samples
_STILL = 0.1  # share of the stamps that several samples have where a clock stands still
_COPIES = 0.01  # share of the samples of one stamp that may differ where the rest are copies
_PACES = 8  # blocks, of which most have the pace of the clock
_PACE = 0.02  # relative, by which real clocks never differ
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
    """`series` by its stamps where they can be trusted, else by the recorder's times; without copies and unset stamps.

    Stamps of simulated time are trusted whatever the recorder's clock says: that does not know how fast it runs.
    """
    series = _without_copies(_without_unset(series, where), where)
    if series.received is None or series.time.size == 0:
        return series
    if _is_simulated(series):
        return series
    is_ordered = bool((np.diff(series.time) > 0).all())
    ordered = series if is_ordered else series.at(np.argsort(series.time, kind="stable"))
    if is_set_back(series.time):
        why = "its clock was set back while recording"
    elif not is_ordered and _stands_still(series.time):
        why = "its stamps stand still"
    elif (step := _line(series).step) and _leaps(ordered):
        why = f"its clock was set while recording, its stamps step by {step:.3g} s"
    else:
        return ordered
    return _as_recorded(series, f"{where}: {why}")


def _as_recorded(series: Series, why: str) -> Series:
    note = f"{why}; the times at which it was recorded are used"
    assert series.received is not None
    return replace(series, time=series.received, received=None, notes=(*series.notes, note))


def _without_unset(series: Series, where: str) -> Series:
    """Without the samples whose time is 0 although the others are far from it; by the recorder's if most are."""
    unset = series.time == 0
    rest = series.time[~unset]
    count, n = int(np.count_nonzero(unset)), series.time.size
    if count == 0 or (rest.size and np.abs(rest).min() <= np.ptp(rest)):
        return series  # a clock that starts at 0 runs through what follows
    if 2 * count < n:
        note = f"{where}: {count} of {n} samples have no time (0) and are left out"
        return series.at(np.flatnonzero(~unset), note)
    return series if series.received is None else _as_recorded(series, f"{where}: its stamps are unset")


def _without_copies(series: Series, where: str) -> Series:
    """Without the samples that repeat time and value of an earlier one: sent or recorded twice, held, played in a loop.

    Where those of one time differ they are samples whose clock is too coarse; where all values are one nothing tells.
    """
    if (np.diff(series.time) > 0).all() or (series.value == series.value[:1]).all():
        return series
    order = np.argsort(series.time, kind="stable")
    again = np.diff(series.time[order]) == 0
    value = series.value[order]
    same = again & (value[1:] == value[:-1])
    copies, repeats = np.count_nonzero(same), np.count_nonzero(again)
    if copies == 0 or repeats - copies > _COPIES * repeats:
        return series
    note = f"{where}: {copies} of {order.size} samples repeat time and value of another and are left out"
    return series.at(np.sort(order[np.r_[True, ~same]]), note)


def _stands_still(time: Nanoseconds) -> bool:
    """Whether many times are those of several samples. Where time is paused, many samples have one."""
    _, counts = np.unique(time, return_counts=True)
    return bool(np.mean(counts > 1) > _STILL)


def _leaps(series: Series) -> bool:
    """Whether stamps leap where the recorder's clock does not; else the recorder was late, or paused with the rest."""
    assert series.received is not None
    stamps, received = np.diff(series.time), np.diff(series.received)
    limit = 1e9 * _line(series).limit
    return bool(
        ((np.abs(stamps - received) > limit) & (np.abs(stamps - usual_step(series.time)) > limit)).any()
    )


def _is_simulated(series: Series) -> bool:
    """Whether its stamps run, but at another pace than the recorder's clock, as no two real clocks do."""
    received = series.received
    if received is None or received.size < _PACES * _LEAST_BLOCK:
        return False
    edges = np.linspace(0, received.size, _PACES + 1).astype(int)
    late = received - series.time
    least = [a + int(np.argmin(late[a:b])) for a, b in pairwise(edges.tolist())]
    lasts, runs = np.diff(received[least]), np.diff(series.time[least])
    drift = np.abs(lasts - runs)
    is_real = np.median(drift - _PACE * np.abs(lasts)) <= 0.0 or np.median(drift) < 1e9 * LEAST_SHIFT
    return not is_real and bool(np.median(runs) > 0)


def to_clock_of(series: Series, force: Series, where: str) -> Series:
    """`series` on the clock of the force: shifted, and noted, where the two clocks are clearly not one.

    **Raises:** `InputError` when nothing relates the two.
    """
    own, other = _line(series), _line(force)
    if _steps_back(force.received) > 1e9 * other.limit:
        if series.received is not None:
            return series  # the recorder's clock tells nothing; the stamps may well be of one clock
        raise InputError(
            f"{where}: has no stamps, and the recorder's clock was set back while recording; give its messages a header"
            ", or cut the recording there"
        )
    if _is_simulated(force) or other.step:
        series, other = _through(series, force, where), _NO_LINE
        own = _line(series)
    elif _is_simulated(series) or own.step:
        series, own = _as_recorded(series, f"{where}: its clock does not run as that of the force"), _NO_LINE
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


def _steps_back(received: Nanoseconds | None) -> int:
    """How far the recorder's times lie before an earlier one at most, ns."""
    return 0 if received is None else int((np.maximum.accumulate(received) - received).max(initial=0))


def _through(series: Series, force: Series, where: str) -> Series:
    """`series` as recorded by the clock of the force: what arrived together was sent together."""
    assert force.received is not None
    begin, zero = int(force.received[0]), int(force.time[0])
    arrived, stamped = np.maximum.accumulate(force.received) - begin, force.time - zero
    received = (series.time if series.received is None else series.received) - begin
    seen = np.interp(received, arrived, stamped)
    pace = float(stamped[-1]) / max(float(arrived[-1]), 1.0)
    seen += pace * (np.minimum(received, 0) + np.maximum(received - arrived[-1], 0))
    moved = zero + np.rint(seen).astype(np.int64)
    if series.received is not None:
        return replace(series, received=moved)
    note = (
        f"{where}: has no stamps of its own; each value is placed where it arrived among those of the force"
    )
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

"""Signals stamped by different clocks, brought to one.

A stamp s that reaches the recorder at r has r - s = offset + delay, delay >= 0: the least of many differences
is the clock's offset and the shortest delay. Its course over the recording is the drift between the clocks.
"""

from dataclasses import replace

import numpy as np

from acf_jax.recording.series import Array, Series

APART = 0.1  # s; no delay between two topics of one clock is that long
_BLOCKS = 32
_FRESH = 0.9  # share of the stamps that differ where a clock is set and runs
_LEAST_SPAN = 10.0  # s; a drift over less is not worth a slope


def settle(series: Series, where: str) -> Series:
    """`series` in the order of its stamps where they can be trusted, else by the recorder's times."""
    if series.received is None or series.time.size == 0:
        return series
    increasing = (np.diff(series.time) > 0).all()
    ordered = series if increasing else series.at(np.argsort(series.time, kind="stable"))
    fresh = 1 + np.count_nonzero(np.diff(ordered.time))
    if ordered.time[0] > 0 and fresh >= _FRESH * ordered.time.size:
        return ordered
    note = f"{where}: its stamps are unset or stand still; the times at which it was recorded are used"
    return replace(series, time=series.received, received=None, notes=(*series.notes, note))


def to_clock_of(series: Series, force: Series, where: str) -> Series:
    """`series` on the clock of the force: shifted, and noted, where the two clocks are clearly not one."""
    shift = _offset(series, series.time) - _offset(force, series.time)
    middle = float(np.median(shift)) if shift.size else 0.0
    if abs(middle) < APART:
        return series
    drift = float(shift[-1] - shift[0])
    note = f"{where}: its clock is {abs(middle):.6g} s {'behind' if middle > 0 else 'ahead of'} that of the force"
    note += f" and drifts by {1e3 * drift:+.3g} ms" if abs(drift) > 1e-3 else ""
    moved = series.time + np.rint(1e9 * shift).astype(np.int64)
    return replace(series, time=moved, notes=(*series.notes, f"{note}; shifted by the recorder's times"))


def _offset(series: Series, at: np.ndarray) -> Array:
    """Recorder's time minus the series' at the times `at` (ns), by the least delays, s."""
    if series.received is None or series.time.size == 0:
        return np.zeros(at.size)
    difference = (series.received - series.time) * 1e-9
    blocks = np.array_split(np.arange(difference.size), min(_BLOCKS, max(difference.size // 8, 1)))
    least = np.array([block[np.argmin(difference[block])] for block in blocks if block.size])
    time = (series.time[least] - series.time[0]) * 1e-9
    if least.size < 4 or time[-1] < _LEAST_SPAN:
        return np.full(at.size, difference.min())
    slope, start = np.polyfit(time, difference[least], 1)
    return np.asarray(start + slope * (at - series.time[0]) * 1e-9)

"""The force while nothing is touched: its course, its noise, and the direction of contact.

A sensor drifts, steps when its tool turns, and was perhaps never tared; contact comes within milliseconds. So what
counts is how far the force jumps from the median of the last moments; how far it has to, the whole recording tells.
An impact, unlike a release, overshoots the force that follows it: on that side is contact.
"""

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from acf_jax.errors import InputError
from acf_jax.recording.series import Array

Indices = NDArray[np.int64]

CLEAR = 8.0  # standard deviations of the noise that no approach reaches
SHARE = 0.05  # of the highest lasting force, so that the inertia of a tool is no contact
DEBOUNCE = 3  # samples: shorter gaps and runs are chatter and spikes
_LEAST_WINDOW = 16  # samples that tell a noise
BLOCK = 1 << 20  # samples handled at once
_WINDOWS = 5  # in the time that ends a contact
_MEMORY = 1.4  # times that time: most of it is free once a contact has ended
_SURER = 2.0  # times the overshoots on the other side that turn a sign


@dataclass(frozen=True)
class Level:
    """The force that a moment starts from, and how far it has to jump to be contact."""

    width: int  # samples of a window
    memory: int  # windows
    before: Array  # N, median of the `memory` windows before each; shape (windows + 1,), the last for what is left over
    noise_std: float  # N
    threshold: float  # N above `before`

    def around(self, index: Indices, later: int = 0) -> Array:
        """The level before the samples at `index`, or `later` windows after that, N."""
        return self.before[np.minimum(index // self.width + later, self.before.size - 1)]


def find_level(force: Array, step: float, separation: float, threshold: float | None, where: str) -> Level:
    """The level of a whole recording.

    **Arguments:** `force`: N, shape (N,). `step`: sampling interval, s. `separation`: how long force is gone between
    contacts, s. `threshold`: N, in place of that from the noise. `where`: the signal in words, for messages.

    **Raises:** `InputError` when the recording is too short.
    """
    width = max(round(separation / _WINDOWS / step), _LEAST_WINDOW) if step else _LEAST_WINDOW
    memory = max(round(_MEMORY * separation / (width * step)), 3) | 1 if step else 3
    count = force.size // width
    if count < 5:
        raise InputError(
            f"{where}: holds {force.size} samples, too few to tell contact from approach; record longer"
        )
    means, stds = np.empty(count), np.empty(count)
    many = max(BLOCK // width, 1)
    for a in range(0, count, many):
        b = min(a + many, count)
        windows = force[a * width : b * width].reshape(b - a, width)
        means[a:b], stds[a:b] = windows.mean(1), windows.std(1)
    first = np.full(memory, np.median(means[:memory]))
    before = np.median(sliding_window_view(np.r_[first, means], memory), axis=1)
    away = means - before[:-1]
    calm = stds <= 3.0 * np.quantile(stds, 0.25)
    near = calm & (np.abs(away) <= max(CLEAR * float(np.median(stds[calm])), 0.02 * float(np.ptp(away))))
    noise = float(np.median(stds[near if near.any() else calm]))

    least = max(CLEAR * noise, SHARE * float(away.max())) if threshold is None else threshold
    return Level(width, memory, before, noise, least)


def is_negative(force: Array, level: Level) -> bool:
    """Whether it is the jumps downwards that overshoot what follows them, so that contact reads negative."""
    return _overshoot(force, level, -1.0) > _SURER * _overshoot(force, level, 1.0)


def jumps(force: Array, level: Level, sign: float = 1.0) -> tuple[Indices, Indices]:
    """First index and index behind the last of each run beyond the threshold, without spikes and chatter."""
    rows = max(BLOCK // level.width, 1)
    edges, last = [], np.zeros(1, np.int8)
    for a in range(0, level.before.size, rows):
        part = force[a * level.width : (a + rows) * level.width]
        limit = np.repeat(sign * level.before[a : a + rows] + level.threshold, level.width)
        above = (sign * part > limit[: part.size]).astype(np.int8)
        edges.append(a * level.width + np.flatnonzero(np.diff(above, prepend=last)))
        last = above[-1:] if above.size else last
    every = np.concatenate([*edges, [force.size] if last[0] else []]).astype(np.int64)
    return debounced(every[::2], every[1::2])


def debounced(starts: Indices, stops: Indices) -> tuple[Indices, Indices]:
    """Runs joined over gaps of fewer than `DEBOUNCE` samples, then without those that are as short."""
    if starts.size > 1:
        apart = starts[1:] - stops[:-1] >= DEBOUNCE
        starts, stops = starts[np.r_[True, apart]], stops[np.r_[apart, True]]
    lasting = stops - starts >= DEBOUNCE
    return starts[lasting], stops[lasting]


def _overshoot(force: Array, level: Level, sign: float) -> float:
    """How far all jumps towards `sign` go beyond both the level before and the level after, N in all."""
    starts, stops = jumps(force, level, sign)
    if starts.size == 0:
        return 0.0
    best = np.maximum if sign > 0.0 else np.minimum
    highest = best.reduceat(force, np.c_[starts, np.minimum(stops, force.size - 1)].ravel())[::2]
    beyond = sign * (highest - best(level.around(starts), level.around(starts, level.memory + 1)))
    return float(beyond[beyond > level.threshold].sum())

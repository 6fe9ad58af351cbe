"""Single readings that are no measurement: lost on the way or disturbed, and put down by the recorder all the same.

What one to three samples of a force read lies near what the samples on both sides say. Where it does not, and the
samples around are smooth, these readings are lost: -9999 or 0 in place of one that never came, the last one again, a
spike of the cable.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acf_jax.dataset.noise import OF_MEDIAN, quantisation_step, robust_std
from acf_jax.dataset.trials import Array, Trace

IN_A_ROW = 3  # readings that may be lost together; more leave too little to tell what was between
SPAN = 5  # samples that these may lie within
CLEAR = 8.0  # times what noise makes of readings nearby, by which a lost one is off at least,
ROUGH = 4.0  # times what the readings next to it are off,
STEEP = (
    2.0  # times the change from sample to sample there: the tip of a sharp peak is off by two thirds of it
)
REPEATED = 0.75  # of CLEAR and ROUGH are enough for a reading that is the last one again to the digit
NEARBY = 41  # samples among which noise is told
SHARED = 0.5  # of what a trial's reading is off, over its largest force, by which a repeat shows the same
LEAST = 12  # samples, of which fewer tell nothing
MOST = 0.05  # of a trial's readings: one that lost more is not to be trusted
APART = NEARBY + 2 * SPAN  # samples, farther than which a lost reading is no part of how others are judged


class Lost(NamedTuple):
    """A reading that is lost."""

    time: float  # s
    force: float  # N, as read


class Readings(NamedTuple):
    """One trace, and how far each reading lies above what the two on either side say, N."""

    time: Array
    force: Array
    off: Array
    top: float  # N, largest force above the median reading before contact, lost readings apart
    rest: float  # N, that median

    @classmethod
    def of(cls, trace: Trace) -> "Readings":
        """The readings of a trace."""
        before = trace.force[trace.time < 0.0]
        rest = float(np.median(before)) if before.size else 0.0
        top = float(np.sort(trace.force)[-1 - IN_A_ROW]) - rest
        return cls(trace.time, trace.force, _off(trace.time, trace.force), max(top, 1e-9), rest)


def without_lost(
    traces: Sequence[Trace | None], repeats: Sequence[Sequence[int]]
) -> list[tuple[Trace | None, tuple[Lost, ...]]]:
    """Each trace without its lost readings, and these.

    What most other repeats of its condition show at the same time as well is the rig, and kept: but not before
    contact, and not what no force can be.

    **Arguments:** `repeats`: the trials (by index) of each condition; those of one that has none are compared with all.
    """
    known = {i: Readings.of(t) for i, t in enumerate(traces) if t is not None and t.time.size >= LEAST}
    usual = float(np.median([robust_std(x.off) for x in known.values()])) if known else 0.0
    alike = {i: [j for j in group if j != i and j in known] for group in repeats for i in group}
    result: list[tuple[Trace | None, tuple[Lost, ...]]] = []
    for i, trace in enumerate(traces):
        if trace is None or i not in known:
            result.append((trace, ()))
            continue
        peers = [known[j] for j in alike[i] or known if j != i]
        kept, lost = _sifted(known[i], peers, usual)
        result.append((Trace(trace.time[kept], trace.force[kept]) if lost else trace, lost))
    return result


def _sifted(own: Readings, peers: list[Readings], usual: float) -> tuple[NDArray[np.bool_], tuple[Lost, ...]]:
    """(n,) which readings are kept, and the lost ones; `usual`: how far readings of all trials are off, N."""
    least = max(quantisation_step(own.force), usual)
    kept, of_rig = np.ones(own.time.size, bool), np.zeros(own.time.size, bool)
    lost: list[Lost] = []
    near = np.ones(own.time.size, bool)  # readings near one that was taken out: they are judged anew
    while (index := np.flatnonzero(kept)).size >= LEAST and len(lost) <= MOST * own.time.size and near.any():
        rest = _Rest(own.time[index], own.force[index], near[index], least)
        near[:] = False
        for found in rest.suspects():
            run = index[found]
            if of_rig[run].any():
                continue
            if _is_of_rig(own, run, peers):
                of_rig[run] = True
            else:
                around = slice(max(found[0] - APART, 0), found[-1] + APART + 1)
                rest.is_open[around], near[index[around]], kept[run] = False, True, False
                lost += map(Lost, own.time[run].tolist(), own.force[run].tolist())
    return kept, tuple(sorted(lost))


class _Rest:
    """The readings that are left of a trace, among which the next lost ones are looked for."""

    def __init__(self, time: Array, force: Array, is_open: NDArray[np.bool_], least: float):
        from scipy.ndimage import median_filter  # slow to import, and not every command reads traces

        self.time, self.force = time, force
        self.size = np.abs(_off(time, force))
        # the standard deviation that noise gives to `size`
        noise = OF_MEDIAN * median_filter(self.size[2:-2], NEARBY, mode="reflect")
        self.noise = np.maximum(np.pad(noise, 2, mode="edge"), least)
        self.change = np.abs(np.diff(force))
        self.again = np.append(False, self.change == 0.0)
        self.is_open = is_open  # whether a reading is to be judged

    def suspects(self) -> Iterator[NDArray[np.intp]]:
        """Readings that lie far off those around them, farthest first, the fewest that explain it."""
        least = np.where(self.again, REPEATED, 1.0) * CLEAR * self.noise / IN_A_ROW
        for i in sorted(np.flatnonzero(self.size > least), key=lambda i: -self.size[i]):
            if not self.is_open[i]:
                continue
            spans = ((first, k) for k in range(1, SPAN + 1) for first in range(i - k + 1, i + 1))
            found = next((far for first, k in spans if (far := self._far_in(first, k)).size), None)
            if found is not None:
                yield found

    def _far_in(self, first: int, k: int) -> NDArray[np.intp]:
        """Which of the `k` readings from `first` on are off what those on both sides say; empty unless its ends are."""
        n, stop, none = self.force.size, first + k, np.empty(0, np.intp)
        before, after = np.arange(max(first - 3, 0), first), np.arange(stop, min(stop + 3, n))
        if first < 0 or stop > n or 0 < min(before.size, after.size) < 3:
            return none
        nodes = np.r_[before[-2:], after[:2]]
        away = self.force[first:stop] - _through(self.time[nodes], self.force[nodes], self.time[first:stop])
        near = self.size[np.r_[max(first - 5, 0) : max(first - 2, 0), min(stop + 2, n) : min(stop + 5, n)]]
        if not near.size:
            return none
        limit = max(CLEAR * float(self.noise[first]), ROUGH * float(near.max()))
        sides = [float(self.change[side[:-1]].max()) for side in (before, after) if side.size]
        if not before.size and self.time[after[-1]] >= 0:
            return none  # contact may have begun there
        if (
            before.size != after.size
        ):  # at an end the force may have gone on as it did, and noise counts for more
            limit, across = limit * (k + 1), k * max(sides)
        else:
            across = abs(float(self.force[stop] - self.force[first - 1])) / (k + 1)
        far = np.flatnonzero(np.abs(away) > max(limit, STEEP * max(*sides, across)))
        # where the force moves before and behind it, the same digits once more are enough
        again = self._repeats_the_last(first, k) and min(sides) > 0.5 * np.abs(away).min()
        if again and np.abs(away).min() > REPEATED * limit:
            far = np.arange(k)
        is_whole = far.size and far[0] == 0 and far[-1] == k - 1
        is_one = abs(np.sign(away[far]).sum()) == far.size <= IN_A_ROW
        return first + far if is_whole and is_one else none

    def _repeats_the_last(self, first: int, k: int) -> bool:
        """Whether these readings are the one before them again, and no part of a longer run of equal ones."""
        if first < 2 or first + k >= self.force.size or self.force[first] == self.force.max():
            return False
        is_alone = not self.again[first - 1] and not self.again[first + k]
        return is_alone and bool(self.again[first : first + k].all())


def _is_of_rig(own: Readings, run: NDArray[np.intp], peers: list[Readings]) -> bool:
    """Whether a sudden force is the rig's: most peers show it at the same time, and it is one that can be."""
    interval = float(np.median(np.diff(own.time)))
    begin, end = float(own.time[run[0]]), float(own.time[run[-1]])
    reading = float(own.force[run[0]])
    if end < -1.5 * interval or reading - own.rest < -own.top or reading == 0.0:
        return False
    worst = run[np.argmax(np.abs(own.off[run]))]
    sign, share = np.sign(own.off[worst]), abs(own.off[worst]) / own.top
    there = [np.abs(p.time - 0.5 * (begin + end)) <= 0.5 * (end - begin) + 1.5 * interval for p in peers]
    show = [
        (sign * p.off[here] >= SHARED * share * p.top).any() for p, here in zip(peers, there, strict=True)
    ]
    # what a rig does varies with its noise: the same digits again are put in
    is_put_in = all(
        (p.force[here] == reading).any() and not np.array_equal(p.force, own.force)
        for p, here in zip(peers, there, strict=True)
    )
    return 2 * sum(show) >= max(len(peers), 1) and not is_put_in


def _off(time: Array, force: Array) -> Array:
    """How far each reading lies above the cubic through the two on either side, N; at an end the line through two."""
    off = np.zeros(force.size)
    for end in (slice(None), slice(None, None, -1)):
        f = force[end]
        off[end][:2] = f[:2] - 2 * f[1:3] + f[2:4]
    parts = [slice(k, force.size - 4 + k) for k in range(5)]
    middle, sides = parts[2], (parts[0], parts[1], parts[3], parts[4])
    off[middle] = force[middle]
    for a in sides:
        others = [b for b in sides if b is not a]
        weights = [(time[middle] - time[b]) / (time[a] - time[b]) for b in others]
        off[middle] -= np.prod(weights, axis=0) * force[a]
    return off


def _through(time: Array, force: Array, at: Array) -> Array:
    """The polynomial through a few samples, by Lagrange."""
    total = np.zeros(at.size)
    for a in range(time.size):
        others = np.delete(time, a)
        total += force[a] * np.prod((at[:, None] - others) / (time[a] - others), axis=1)
    return total

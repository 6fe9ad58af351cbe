"""Readings that a recorder repeats because it asks faster than the sensor measures."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from acf_jax.dataset.trials import Array, Trace

LEAST = 12  # changes of a reading, of which fewer tell nothing
LONGEST = 64  # samples that a reading may be held for
REGULAR = 0.95  # of the changes come when a hold ends
TURNS = 0.85  # of the runs of equal readings are as long as a hold makes them: chance makes some longer
REPEATED = 0.25  # of the runs are of two samples where a hold is shorter than that,
OFF_BEAT = (
    1.5  # and the changes lie within so many samples about a regular beat: by chance they drift away from any
)


def held_for(force: Array) -> float:
    """For how many samples each reading is held; 1 where none is.

    A sensor at 1/r of the recorder's rate changes every r samples, whatever it reads. Where r is no whole number, runs
    of equal readings take turns between the two about it. Readings that are equal because their steps are coarse, or
    because the force is at rest, change at any sample and make runs of any length.
    """
    changes = _changes(force)
    if changes.size < LEAST:
        return 1.0
    whole = np.arange(min(LONGEST, force.size // LEAST), 1, -1)
    alike = [np.bincount(changes % r).max() / changes.size for r in whole]
    if (fits := np.flatnonzero(np.array(alike) >= REGULAR)).size:
        return float(whole[fits[0]])  # the longest: changes every four samples are some of those every two
    lengths = np.diff(changes)
    shares = np.append(np.bincount(lengths, minlength=3) / lengths.size, 0.0)
    short = int(np.argmax(shares[:-1] + shares[1:]))  # the most frequent lengths are this one and the next
    usual = lengths[(lengths == short) | (lengths == short + 1)]
    if usual.size < TURNS * lengths.size or (short == 1 and shares[2] < REPEATED):
        return 1.0
    held = float(usual.mean())
    if short == 1:
        beat = np.cumsum(np.where(lengths <= 2, 1, np.round(lengths / held)))
        late = changes[1:] - np.polyval(np.polyfit(beat, changes[1:], 1), beat)
        return held if np.ptp(late) < OFF_BEAT else 1.0
    return held


def one_of_each(trace: Trace, held: float) -> Trace:
    """The first sample of each reading: then it was new. A first reading whose age is unknown is left out."""
    kept = np.zeros(trace.force.size, bool)
    edges = np.append(_changes(trace.force), trace.force.size)
    for first, last in pairwise(edges):
        # what is equal for longer than a hold are several readings
        kept[np.round(np.arange(first, last - 0.5 * held, held)).astype(int)] = True
        kept[first] = True
    return Trace(trace.time[kept], trace.force[kept])


def _changes(force: Array) -> NDArray[np.intp]:
    """Indices of the samples that differ from the one before."""
    return np.flatnonzero(np.diff(force) != 0.0) + 1

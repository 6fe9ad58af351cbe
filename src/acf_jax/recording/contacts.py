"""Contacts in a recording of minutes: where they begin, what the sensor read before, how sure that is.

Twice: over the whole recording by a threshold that the force before contact sets, runs above it debounced; then at
each contact alone, where the samples around the crossing tell the onset by maximum likelihood: noise about the
offset before it, a parabola from it on.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acf_jax.errors import InputError
from acf_jax.recording.mapping import Contacts
from acf_jax.recording.series import Array, Series

Indices = NDArray[np.int64]

CLEAR = 8.0  # standard deviations of the noise that no approach reaches
SHARE = 0.05  # of the highest lasting force, so that the inertia of a tool is no contact
DEBOUNCE = 3  # samples: shorter gaps and runs are chatter and spikes
LEAST_APPROACH = 20  # samples, as a data set wants
_WINDOW = 0.02  # s, over which level and noise are taken
_APPROACH = 0.25  # s before a contact that tell its offset and noise
_OBVIOUS = 30.0  # standard deviations of the noise at which an onset needs no more samples
_BLOCK = 1 << 20  # samples handled at once
_MOST = 10_000  # contacts


@dataclass(frozen=True)
class Level:
    """The force while nothing is touched."""

    free: float  # N
    noise_std: float  # N
    threshold: float  # N above `free`
    highest: float  # N, of the means over windows


@dataclass(frozen=True)
class Contact:
    """One contact, from its first impact until the force is gone."""

    begin: int  # ns, first contact; up to a sample before the first sample that shows it
    first: int  # index of that sample
    stop: int  # index behind the last sample in contact
    approach: int  # index from which the samples belong to its approach
    offset: float  # N, median of the approach
    noise_std: float  # N, about it
    peak: float  # N, largest sample within the contact

    @property
    def rise(self) -> float:
        """The peak above the force before contact, N."""
        return self.peak - self.offset


def find_contacts(force: Series, options: Contacts, where: str) -> tuple[Level, list[Contact]]:
    """Every contact of the recording.

    **Arguments:** `force`: N, positive in contact. `where`: the signal in words, for messages.

    **Raises:** `InputError` when the recording is too short, the force has the wrong sign, or no contact is seen.
    """
    step = sampling_interval(force)
    width = max(round(_WINDOW / step), 16) if step else 16
    level = _level(force.value, width, options.threshold_n, where)
    starts, stops = _runs(force.value, level.free + level.threshold)
    starts, stops = _debounced(force, starts, stops, round(1e9 * options.separation_s))
    if starts.size == 0:
        raise InputError(_nothing(level, where))
    if starts.size > _MOST:
        raise InputError(
            f"{where}: crosses {level.threshold:.3g} N {starts.size} times; state a higher threshold_n"
        )
    before = np.r_[0, stops[:-1]]
    found = zip(starts.tolist(), stops.tolist(), before.tolist(), strict=True)
    return level, [contact_at(force, start, stop, last, step) for start, stop, last in found]


def contact_at(force: Series, crossing: int, stop: int, last: int, step: float) -> Contact:
    """The contact whose force is clear at the index `crossing`; the one before it ended at `last`.

    **Arguments:** `step`: sampling interval, s.
    """
    # what follows a release still moves: the second half of the pause is the approach
    earliest = last if last == 0 else last + (crossing - last) // 2
    approach = max(earliest, crossing - round(_APPROACH / step))
    samples = force.value[approach:crossing]
    offset, noise = _centre(samples) if samples.size else (0.0, 0.0)
    first, early = _onset(force.value, approach, crossing, stop, offset, noise)
    own = int(force.time[first] - force.time[first - 1]) if first else round(1e9 * step)
    return Contact(
        begin=int(force.time[first]) - round(early * own),
        first=first,
        stop=stop,
        approach=approach,
        offset=offset,
        noise_std=noise,
        peak=float(force.value[first:stop].max()),
    )


def sampling_interval(series: Series) -> float:
    """Median time between two samples, s; 0 of a single one."""
    steps = np.diff(series.time[:_BLOCK])
    return 1e-9 * float(np.median(steps)) if steps.size else 0.0


def _level(force: Array, width: int, threshold: float | None, where: str) -> Level:
    count = force.size // width
    if count < 5:
        raise InputError(
            f"{where}: holds {force.size} samples, too few to tell contact from approach; record longer"
        )
    means, stds = np.empty(count), np.empty(count)
    many = max(_BLOCK // width, 1)
    for a in range(0, count, many):
        b = min(a + many, count)
        windows = force[a * width : b * width].reshape(b - a, width)
        means[a:b], stds[a:b] = windows.mean(1), windows.std(1)
    calm = stds <= 3.0 * np.median(stds)
    near = np.sort(means[calm][np.argsort(np.abs(means[calm]))[: max(int(0.05 * count), 3)]])
    middle, spread = float(near[near.size // 2]), float(np.ptp(means))
    free = calm & (np.abs(means - middle) <= max(CLEAR * float(np.median(stds[calm])), 0.02 * spread))
    at, noise = float(np.median(means[free])), float(np.median(stds[free]))
    up, down = float(means.max()) - at, at - float(means.min())
    least = max(CLEAR * noise, SHARE * up) if threshold is None else threshold
    if down > max(3.0 * up, 2.0 * least):
        raise InputError(
            f"{where}: is negative in contact (down to {at - down:.4g} N, {at:.3g} N before contact);"
            " turn its sign: put -1* before its name, or write scale: -1"
        )
    return Level(at, noise, least, at + up)


def _nothing(level: Level, where: str) -> str:
    return (
        f"{where}: shows no contact: it stays within {level.threshold:.3g} N of the {level.free:.3g} N before contact;"
        " name another topic, axis or column, or state contacts.threshold_n in the mapping"
    )


def _runs(force: Array, limit: float) -> tuple[Indices, Indices]:
    """First index and index behind the last of each run above `limit`."""
    edges, before = [], np.zeros(1, np.int8)
    for a in range(0, force.size, _BLOCK):
        above = (force[a : a + _BLOCK] > limit).astype(np.int8)
        edges.append(a + np.flatnonzero(np.diff(above, prepend=before)))
        before = above[-1:]
    every = np.concatenate([*edges, [force.size] if before[0] else []]).astype(np.int64)
    return every[::2], every[1::2]


def _debounced(force: Series, starts: Indices, stops: Indices, separation: int) -> tuple[Indices, Indices]:
    """Runs joined over short gaps, spikes dropped, then joined over every gap shorter than `separation`, ns."""
    starts, stops = _joined(starts, stops, starts[1:] - stops[:-1] < DEBOUNCE)
    lasting = stops - starts >= DEBOUNCE
    starts, stops = starts[lasting], stops[lasting]
    if starts.size == 0:
        return starts, stops
    gaps = force.time[starts[1:]] - force.time[stops[:-1] - 1]
    return _joined(starts, stops, gaps < separation)


def _joined(starts: Indices, stops: Indices, to_next: NDArray[np.bool_]) -> tuple[Indices, Indices]:
    if starts.size < 2:
        return starts, stops
    return starts[np.r_[True, ~to_next]], stops[np.r_[~to_next, True]]


def _centre(samples: Array) -> tuple[float, float]:
    """Median, and the standard deviation about it that a few odd samples do not change."""
    middle = float(np.median(samples))
    spread = 1.4826 * float(np.median(np.abs(samples - middle)))
    return middle, spread if spread > 0.0 else float(samples.std())


def _onset(
    force: Array, approach: int, crossing: int, stop: int, offset: float, noise: float
) -> tuple[int, float]:
    """Index of the first sample in contact, and by which share of a sample contact came before it.

    A force that jumps was touched anywhere in the last interval: half of it. One that climbs from the offset
    began where the line meets it.
    """
    scale = max(noise, 1e-9 * max(abs(offset), 1.0))
    # a slow climb needs more samples than a jump to stand out of the noise
    clear = np.argmax(force[crossing : crossing + 4 * DEBOUNCE] > offset + _OBVIOUS * scale)
    end = min(crossing + max(int(clear), DEBOUNCE + 1), stop)
    begin = max(approach, crossing - 10 * DEBOUNCE)
    rest = (force[begin:end] - offset) / scale
    quiet = np.r_[0.0, np.cumsum(rest**2)]
    losses, slopes, heights = [], [], []
    for k in range(crossing - begin + 1):
        x = np.arange(rest.size - k, dtype=float)
        fit = np.polynomial.polynomial.polyfit(x, rest[k:], min(2, x.size - 1))
        losses.append(quiet[k] + float(((np.polynomial.polynomial.polyval(x, fit) - rest[k:]) ** 2).sum()))
        heights.append(float(fit[0]))
        slopes.append(float(fit[1]) if fit.size > 1 else 0.0)
    best = int(np.argmin(losses))
    share = heights[best] / slopes[best] if slopes[best] > 0.0 else np.inf
    return begin + best, float(np.clip(share, 0.0, 1.0)) if share <= 1.0 else 0.5

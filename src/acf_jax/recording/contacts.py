"""Contacts in a recording of minutes: where they begin, what the sensor read before, how sure that is.

Twice: over the whole recording by jumps from the force just before, each a contact until the force has fallen back;
then at each contact alone, where the samples around the crossing tell the onset.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from acf_jax.errors import InputError
from acf_jax.recording.level import BLOCK, DEBOUNCE, Level, debounced, find_level, is_negative, jumps
from acf_jax.recording.mapping import Contacts
from acf_jax.recording.onset import onset_at, rest_of
from acf_jax.recording.series import Series

APPROACH = 0.25  # s before a contact that tell its offset and noise
_MOST = 10_000  # contacts
_RISES = 10  # of a contact that may be its impact
_FIRST = 0.5  # of the highest rise soon after it that a first impact reaches
_CALM = 0.9  # share of samples

Run = tuple[int, int]  # first index, index behind the last


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
    rises: tuple[Run, ...] = ()  # the first and those soon after it, which may be the impact as well
    is_late: bool = False  # it begins at a later one of them
    stays: float = 0.0  # N, above the offset when the next contact begins; 0: it falls back

    @property
    def rise(self) -> float:
        """The peak above the force before contact, N."""
        return self.peak - self.offset


@dataclass
class _Stretch:
    """Jumps that are one contact, while they are put together."""

    level: float  # N, before the first
    runs: list[Run]
    stop: int
    stays: float = 0.0  # N


class WrongSign(InputError):
    """The force is negative in contact."""


def find_contacts(
    force: Series, options: Contacts, where: str, remedy: str = "put -1* before its name"
) -> tuple[Level, list[Contact]]:
    """Every contact of the recording.

    **Arguments:** `force`: N, positive in contact. `where`: the signal in words, for messages. `remedy`: of a wrong
    sign, in words.

    **Raises:** `InputError` when the recording is too short, or no contact is seen; `WrongSign`.
    """
    step = sampling_interval(force)
    level = find_level(force.value, step, options.separation_s, options.threshold_n, where)
    if is_negative(force.value, level):
        low, free = float(force.value.min()), float(np.median(level.before))
        raise WrongSign(
            f"{where}: is negative in contact (down to {low:.4g} N, {free:.3g} N before contact); {remedy}"
        )
    stretches = _stretches(force, level, round(1e9 * options.separation_s))
    if not stretches:
        windows = np.arange(0, force.value.size, level.width)
        highest = float((np.maximum.reduceat(force.value, windows) - level.around(windows)).max())
        if highest > level.threshold:
            raise InputError(
                f"{where}: jumps by up to {highest:.3g} N, but never for {DEBOUNCE} samples, as in contact; record the"
                " force faster, or if these are spikes of the sensor, name another topic, axis or column"
            )
        raise InputError(
            f"{where}: shows no contact: it never jumps by more than {level.threshold:.3g} N; name another topic, axis"
            " or column, or state contacts.threshold_n in the mapping"
        )
    if len(stretches) > _MOST:
        raise InputError(
            f"{where}: jumps by {level.threshold:.3g} N {len(stretches)} times; state a higher threshold_n"
        )
    return level, list(_contacts(force, stretches, step))


def _stretches(force: Series, level: Level, separation: int) -> list[_Stretch]:
    """Jumps put together: one belongs to the contact before it until that has fallen back for `separation`, ns."""
    starts, stops = jumps(force.value, level)
    stretches: list[_Stretch] = []
    for start, stop, now in zip(starts.tolist(), stops.tolist(), level.around(starts).tolist(), strict=True):
        if stretches:
            open_ = stretches[-1]
            end, is_over = _end(force, open_, start, level.threshold, separation)
            if is_over:
                open_.stop = end
            elif _has_moved(force, open_.level, now, (start, stop), level.threshold, separation):
                open_.stays = now - open_.level
            else:
                open_.runs.append((start, stop))
                open_.stop = stop
                continue
        stretches.append(_Stretch(now, [(start, stop)], stop))
    if stretches:
        stretches[-1].stop, _ = _end(force, stretches[-1], force.time.size, level.threshold, separation)
    return stretches


def _end(force: Series, contact: _Stretch, until: int, threshold: float, separation: int) -> tuple[int, bool]:
    """Index behind the last sample of a contact before `until`, and whether it falls back for `separation`, ns."""
    above = force.value[contact.stop : until] > contact.level + threshold
    edges = contact.stop + np.flatnonzero(np.diff(above, prepend=False, append=False))
    starts, stops = debounced(edges[::2], edges[1::2])
    ends = np.r_[contact.stop, stops]
    gaps = force.time[np.r_[starts, min(until, force.time.size - 1)]] - force.time[ends - 1]
    is_over = gaps >= separation
    return int(ends[np.argmax(is_over)] if is_over.any() else ends[-1]), bool(is_over.any())


def _has_moved(force: Series, before: float, now: float, run: Run, threshold: float, separation: int) -> bool:
    """Whether the free force went from `before` to `now`, so that a jump from there is another contact.

    A contact that is pressed on rises by less than the force it stands on.
    """
    start, stop = run
    calm = force.value[int(np.searchsorted(force.time, force.time[start] - separation)) : start]
    rests = calm.size > 0 and float(np.mean(np.abs(calm - now) < threshold)) > _CALM
    stands = now - before
    return rests and stands > threshold and float(force.value[start:stop].max()) - now > stands


def _contacts(force: Series, stretches: list[_Stretch], step: float) -> Iterator[Contact]:
    last = 0
    for stretch in stretches:
        start, _ = stretch.runs[0]
        contact = contact_at(force, start, stretch.stop, last, step)
        soon = start + round(APPROACH / step) if step else start
        rises = tuple(run for run in stretch.runs if run[0] <= soon)
        yield replace(contact, rises=rises[:_RISES], stays=stretch.stays)
        last = stretch.stop


def first_impact(force: Series, contact: Contact, least: float, lasts: float, step: float) -> Contact:
    """The contact from the first of its rises that can be an impact, if any can.

    A tool that the robot accelerates pushes too, but by far less than the pretension and the impact that follows.

    **Arguments:** `least`: N, that an impact reaches. `lasts`: longest time from first contact to the peak, s.
    `step`: sampling interval, s.
    """
    longest = max(round(lasts / step), 1) if step else 1
    peaks = np.array([force.value[a : min(b, a + longest)].max() for a, b in contact.rises]) - contact.offset
    able = np.flatnonzero(peaks >= max(least, _FIRST * peaks.max()))
    if able.size == 0 or able[0] == 0:
        return contact
    (_, before), (start, _) = contact.rises[able[0] - 1 : able[0] + 1]
    own = contact_at(force, start, contact.stop, before, step)
    return replace(own, rises=contact.rises, is_late=True, stays=contact.stays)


def contact_at(force: Series, crossing: int, stop: int, last: int, step: float) -> Contact:
    """The contact whose force is clear at the index `crossing`; the one before it ended at `last`.

    **Arguments:** `step`: sampling interval, s.
    """
    # what follows a release still moves: the second half of the pause is the approach
    earliest = last if last == 0 else last + (crossing - last) // 2
    approach = max(earliest, crossing - round(APPROACH / step))
    offset, noise = rest_of(force.value[approach:crossing])
    first, early = onset_at(force.value, approach, crossing, stop, offset, noise)
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
    steps = np.diff(series.time[:BLOCK])
    return 1e-9 * float(np.median(steps)) if steps.size else 0.0

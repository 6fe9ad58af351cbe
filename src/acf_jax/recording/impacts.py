"""From the signals of a recording to cuts that a data set can hold."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from acf_jax.dataset import GapDataset, Measurement, RigPrior, Trial, assess_dataset, units
from acf_jax.dataset.noise import approach_samples
from acf_jax.dataset.trust import RATE, Limit, Trust
from acf_jax.errors import InputError
from acf_jax.recording.align import align, drawn, without_apart
from acf_jax.recording.checks import (
    condition_faults,
    force_unit_fault,
    interval_faults,
    is_none,
    nought_of,
    rise_faults,
)
from acf_jax.recording.contacts import Contact, WrongSign, contact_at, find_contacts, sampling_interval
from acf_jax.recording.cut import GAP, Cut, group, spread
from acf_jax.recording.level import BLOCK, Level
from acf_jax.recording.mapping import Contacts
from acf_jax.recording.measure import first_impacts, measured, weighed
from acf_jax.recording.onset import SURE
from acf_jax.recording.rate import impact_duration, too_slow
from acf_jax.recording.review import Entry
from acf_jax.recording.series import Array
from acf_jax.recording.session import Session
from acf_jax.recording.velocity import Estimate

LEAST = 3  # trials of a data set
_SCATTER = 0.05  # relative, of repeats, that a robot does not have
_USUAL = (Measurement.contact_velocity_rel_std, Measurement.pretension_rel_std)
_SAME = 2  # ns within which a reviewed time is the one found


@dataclass(frozen=True)
class Impacts:
    """What came of a recording."""

    session: Session
    level: Level | None  # None: no contact was seen
    cuts: tuple[Cut, ...]
    notes: tuple[str, ...]
    velocity_spread: float | None = None  # relative, trial to trial; None: too few repeats
    pretension_spread: float | None = None
    faults: tuple[str, ...] = ()  # why no data set can come of it
    rig: RigPrior = units.TYPICAL_RIG  # as far as it is known

    @property
    def kept(self) -> list[Cut]:
        """The cuts of the data set."""
        return [cut for cut in self.cuts if cut.keep]

    @cached_property
    def trust(self) -> Trust:
        """Whether the kept contacts can be trusted, as `diagnose` will look at them."""
        trials = [Trial(c.trial, *c.condition, c.peak, c.trace) for c in self.kept]
        spread = (self.velocity_spread, self.pretension_spread)
        velocity, pretension = (usual if x is None else x for x, usual in zip(spread, _USUAL, strict=True))
        measurement = Measurement(None, velocity, pretension)
        dataset = GapDataset(self.session.path, "", self.rig, measurement, tuple(trials))
        try:
            found = assess_dataset(dataset).trust()
        except InputError as error:  # that the noise is not known
            return Trust(self.session.path.name, tuple(Limit("noise", fault) for fault in error.faults))
        step = sampling_interval(self.session.force)
        slow = too_slow(step, impact_duration(self.kept, step, self.rig.impact_time))
        others = (limit for limit in found.limits if limit.word != RATE)
        return found._replace(limits=(Limit(RATE, slow), *others)) if slow else found


class Refused(InputError):
    """No data set can come of a recording; `impacts` is what was found in it all the same."""

    def __init__(self, impacts: Impacts):
        super().__init__(impacts.faults)
        self.impacts = impacts


def find_impacts(
    session: Session, options: Contacts, rig: RigPrior | None, review: Sequence[Entry] | None = None
) -> Impacts:
    """Find, measure, cut and check the contacts of a recording, those of `review` where there is one.

    **Raises:** `Refused` when no contact is seen, a unit, a sign or a clock cannot be right, or fewer than three cuts
    stay.
    """
    known = rig or units.TYPICAL_RIG
    impacts = _found(session, options, known, review)
    if impacts.faults:
        raise Refused(impacts)
    kept = impacts.kept
    velocity, pretension = [c.velocity for c in kept], [c.pretension for c in kept]
    v_e, f_p = group(velocity), without_noise(group(pretension), pretension)
    conditions = iter(zip(v_e.tolist(), f_p.tolist(), strict=True))
    cuts = [replace(cut, condition=next(conditions)) if cut.keep else cut for cut in impacts.cuts]
    scatter = spread(velocity, v_e)
    return replace(
        impacts,
        cuts=tuple(cuts),
        notes=(*impacts.notes, *_notes(impacts.session, kept, scatter, options)),
        velocity_spread=scatter,
        pretension_spread=spread(pretension, f_p),
        rig=known,
    )


def _found(session: Session, options: Contacts, known: RigPrior, review: Sequence[Entry] | None) -> Impacts:
    """The contacts with what was measured at each, and the faults; what comes after a fault is shown, not judged."""
    where, remedy = session.where("force"), session.remedy("force", -1.0)
    step = sampling_interval(session.force)
    faults = interval_faults(session, known.impact_time)
    faults += session.force.notes if faults else ()  # such as why they are not the stamps
    try:
        try:
            level, rises = find_contacts(session.force, options, where, remedy)
        except WrongSign as error:
            if faults or units.is_undersampled(step, known.impact_time):
                raise  # too slow to tell a sign
            faults += error.faults
            turned = replace(session.force, value=-session.force.value)
            session = replace(session, force=turned, notes=(*session.notes, "the force is shown turned"))
            level, rises = find_contacts(turned, options, where)
    except InputError as error:
        if not faults:
            faults += error.faults
            slow = too_slow(step, known.impact_time)
            faults += [f"{where}: {slow}"] if slow else []
        return Impacts(session, None, (), session.notes, faults=tuple(faults))
    shown = session
    try:
        shown = session = align(session, rises)
    except InputError as error:
        faults += error.faults
        shown, session = drawn(session), without_apart(session)
    faults = faults or rise_faults(session, rises, known.impact_time)
    rises = first_impacts(session, rises, known.impact_time)
    named = [(f"t{i:03d}", contact, None) for i, contact in enumerate(rises)]
    chosen = named if review is None else _reviewed(session, rises, review, options.separation_s)
    cuts = measured(session, chosen, options, known.impact_time)
    usable = [cut for cut in cuts if cut.keep]
    faults = faults or condition_faults(session, usable or cuts)
    if not faults and len(usable) >= LEAST and (fault := force_unit_fault(session, usable, known)):
        faults = [fault]
    cuts = weighed(cuts, review is not None)
    slow = too_slow(step, impact_duration([c for c in cuts if c.keep] or cuts, step, known.impact_time))
    # what is wrong with clock or unit makes impacts look short
    notes = (*shown.notes, slow) if slow and not faults else shown.notes
    if not faults and sum(cut.keep for cut in cuts) < LEAST:
        faults = [_too_few(session, cuts, slow)]
    return Impacts(shown, level, tuple(cuts), notes, faults=tuple(faults))


def without_noise(f_p: Array, pretension: Sequence[Estimate]) -> Array:
    """The pretension of each group, N; 0 where it is below zero or, by its least certain trial, none at all.

    **Arguments:** `f_p`: of the group of each trial, N, shape (n,). `pretension`: as measured, of each trial.
    """
    nought, std = nought_of(pretension), np.array([one.std for one in pretension])
    for value in np.unique(f_p):
        alike = f_p == value
        if value < 0.0 or is_none(Estimate(value, std[alike].max()), nought):
            f_p = np.where(alike, 0.0, f_p)
    return f_p


def _too_few(session: Session, cuts: Sequence[Cut], slow: str | None) -> str:
    """That too few contacts can be used, with the remedy. `slow`: that the force is sampled too slowly, if it is."""
    kept = sum(cut.keep for cut in cuts)
    remedy = "record more" if len(cuts) < LEAST else "record more, or mend what stands beside each contact"
    if slow and any(
        not c.keep and (c.peak is None or approach_samples(c.trace).time.size < SURE) for c in cuts
    ):
        remedy = slow
    return (
        f"{session.where('force')}: {kept} of {len(cuts)} contacts can be used; a data set needs at least {LEAST}:"
        f" {remedy}"
    )


def _reviewed(
    session: Session, found: Sequence[Contact], review: Sequence[Entry], separation: float
) -> list[tuple[str, Contact, bool | None]]:
    """The contacts at the times of the review, in order; a time that was found is that contact.

    Another time is that of the nearest contact which no entry names, within `separation`, s: of an entry about which
    nothing is decided that contact itself, else moved there. Without one it is a new contact.
    """
    force = session.force
    step = sampling_interval(force)
    begins = np.array([contact.begin for contact in found])
    entries = sorted(review, key=lambda e: e.contact_s)
    times = np.array([int(force.time[0]) + round(1e9 * entry.contact_s) for entry in entries])
    left = [c for c in found if np.abs(times - c.begin).min(initial=_SAME + 1) > _SAME]
    chosen: list[tuple[str, Contact, bool | None]] = []
    for entry, begin in zip(entries, times.tolist(), strict=True):
        near = int(np.argmin(np.abs(begins - begin)))
        if abs(int(begins[near]) - begin) <= _SAME:
            chosen.append((entry.trial, found[near], entry.keep))
            continue
        first = min(int(np.searchsorted(force.time, begin)), force.time.size - 1)
        later = begins[begins > begin + 1e9 * step]
        end = int(np.searchsorted(force.time, later[0])) if later.size else force.time.size
        moved = [c for c in left if abs(c.begin - begin) < 1e9 * separation]
        if moved:
            nearest = min(moved, key=lambda c: abs(c.begin - begin))
            if entry.keep is None:
                chosen.append((entry.trial, nearest, None))
                left.remove(nearest)
                continue
            end = nearest.stop
        stop = max(min([c.stop for c in found if c.first <= first < c.stop] or [end]), first + 1)
        last = max([c.stop for c in found if c.stop <= first], default=0)
        own = contact_at(force, first, stop, last, step)
        chosen.append((entry.trial, replace(own, begin=begin, first=first), entry.keep))
    return chosen


def _notes(session: Session, kept: Sequence[Cut], scatter: float | None, options: Contacts) -> Iterator[str]:
    """What a user should know of the contacts that are kept."""
    offsets = np.array([cut.contact.offset for cut in kept])
    noise = float(np.median([cut.contact.noise_std for cut in kept]))
    rise = float(np.median([cut.contact.rise for cut in kept]))
    if options.tare and np.abs(offsets).max() > (least := max(3.0 * noise, 0.02 * rise)):
        low, high = float(offsets.min()), float(offsets.max())
        reads = f"{np.median(offsets):.3g} N" if high - low < least else f"{low:.3g} to {high:.3g} N"
        yield f"the force reads {reads} before contact: taken off (`no-tare` keeps it)"
    if late := [cut.trial for cut in kept if cut.contact.is_late]:
        yield f"begun after a pulse too small for an impact: {', '.join(late)}"
    if scatter is not None and scatter > _SCATTER:
        yield f"repeats vary by {100 * scatter:.2g} % in velocity; look at its axis, and at its clock"
    if gap := _gaps(session):
        yield gap
    if doubtful := [cut.trial for cut in kept if cut.remarks]:
        yield f"kept although doubtful: {', '.join(doubtful)}"


def _gaps(session: Session) -> str | None:
    """What is missing in the force; None where nothing is."""
    time, limit = session.force.time, GAP * 1e9 * sampling_interval(session.force)
    blocks = (np.diff(time[a : a + BLOCK + 1]) for a in range(0, time.size, BLOCK))
    gaps = np.concatenate([steps[steps > limit] for steps in blocks])
    if gaps.size == 0:
        return None
    where = session.labels.get("force", "force")
    times = "once, for" if gaps.size == 1 else f"{gaps.size} times, at most for"
    return f"{where}: samples are missing {times} {1e-9 * gaps.max():.3g} s"

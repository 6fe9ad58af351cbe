"""From the signals of a recording to cuts that a data set can hold."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from acf_jax.dataset import units
from acf_jax.dataset.trials import RigPrior
from acf_jax.errors import InputError
from acf_jax.recording.checks import condition_faults, force_unit_fault, interval_fault
from acf_jax.recording.contacts import Contact, contact_at, find_contacts, sampling_interval
from acf_jax.recording.cut import GAP, Cut, group, spread
from acf_jax.recording.level import BLOCK, Level
from acf_jax.recording.mapping import Contacts
from acf_jax.recording.measure import first_impacts, measured, weighed
from acf_jax.recording.review import Entry
from acf_jax.recording.session import Session

LEAST = 3  # trials of a data set
_SCATTER = 0.05  # relative, of repeats, that a robot does not have
_SAME = 2  # ns within which a reviewed time is the one found


@dataclass(frozen=True)
class Impacts:
    """What came of a recording."""

    session: Session
    level: Level
    cuts: tuple[Cut, ...]
    velocity_spread: float | None  # relative, trial to trial; None: too few repeats
    pretension_spread: float | None
    notes: tuple[str, ...]

    @property
    def kept(self) -> list[Cut]:
        """The cuts of the data set."""
        return [cut for cut in self.cuts if cut.keep]


def find_impacts(
    session: Session, options: Contacts, rig: RigPrior | None, review: Sequence[Entry] | None = None
) -> Impacts:
    """Find, measure, cut and check the contacts of a recording, those of `review` where there is one.

    **Raises:** `InputError` when no contact is seen, a unit or sign cannot be right, or fewer than three cuts stay.
    """
    known = rig or units.TYPICAL_RIG
    if fault := interval_fault(session, known.impact_time):
        raise InputError([fault, *session.force.notes])  # such as why they are not the stamps
    where = f"{session.path} {session.labels['force']}"
    level, rises = find_contacts(session.force, options, where)
    found = first_impacts(session, rises, known.impact_time)
    named = [(f"t{i:03d}", contact, None) for i, contact in enumerate(found)]
    chosen = named if review is None else _reviewed(session, found, review, options.separation_s)
    cuts = measured(session, chosen, options, known.impact_time)
    if faults := condition_faults(session, [c for c in cuts if c.keep] or cuts):
        raise InputError(faults)
    usable = [cut for cut in cuts if cut.keep]
    if len(usable) >= LEAST and (fault := force_unit_fault(session, usable, known)):
        raise InputError(fault)
    cuts = weighed(cuts, review is not None, options)
    kept = [cut for cut in cuts if cut.keep]
    if len(kept) < LEAST:
        reasons = "; ".join([f"{c.trial}: {', '.join(c.remarks)}" for c in cuts if c.remarks][:5])
        more = f" ({reasons})" if reasons else ""
        raise InputError(
            f"{where}: {len(kept)} contacts of {len(cuts)} can be used{more}; a data set needs at least {LEAST}:"
            " record more"
        )
    velocity, pretension = [c.velocity for c in kept], [c.pretension for c in kept]
    v_e, f_p = group(velocity), np.maximum(group(pretension), 0.0)
    conditions = iter(zip(v_e.tolist(), f_p.tolist(), strict=True))
    cuts = [replace(cut, condition=next(conditions)) if cut.keep else cut for cut in cuts]
    scatter = spread(velocity, v_e)
    notes = _notes(session, kept, scatter, options)
    return Impacts(session, level, tuple(cuts), scatter, spread(pretension, f_p), notes)


def _reviewed(
    session: Session, found: Sequence[Contact], review: Sequence[Entry], separation: float
) -> list[tuple[str, Contact, bool | None]]:
    """The contacts at the times of the review, in order; a time that was found is that contact.

    Another time is that of the nearest contact which no entry names, within `separation`, s, or a new one.
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
            end = min(moved, key=lambda c: abs(c.begin - begin)).stop
        stop = max(min([c.stop for c in found if c.first <= first < c.stop] or [end]), first + 1)
        last = max([c.stop for c in found if c.stop <= first], default=0)
        own = contact_at(force, first, stop, last, step)
        chosen.append((entry.trial, replace(own, begin=begin, first=first), entry.keep))
    return chosen


def _notes(
    session: Session, kept: Sequence[Cut], scatter: float | None, options: Contacts
) -> tuple[str, ...]:
    notes = list(session.notes)
    offsets = np.array([cut.contact.offset for cut in kept])
    noise = float(np.median([cut.contact.noise_std for cut in kept]))
    rise = float(np.median([cut.contact.rise for cut in kept]))
    if np.abs(offsets).max() > (least := max(3.0 * noise, 0.02 * rise)) and not options.tare:
        low, high = float(offsets.min()), float(offsets.max())
        reads = f"{np.median(offsets):.3g} N" if high - low < least else f"{low:.3g} to {high:.3g} N"
        notes.append(
            f"the force reads {reads} before contact; contacts: {{tare: true}} in the mapping subtracts it"
        )
    if late := [cut.trial for cut in kept if cut.contact.is_late]:
        notes.append(f"begun after a pulse too small for an impact: {', '.join(late)}")
    if scatter is not None and scatter > _SCATTER:
        notes.append(f"repeats vary by {100 * scatter:.2g} % in velocity; look at its axis, and at its clock")
    if gap := _gaps(session):
        notes.append(gap)
    if doubtful := [cut.trial for cut in kept if cut.remarks]:
        notes.append(f"kept although doubtful: {', '.join(doubtful)}")
    return tuple(notes)


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

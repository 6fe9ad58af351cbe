"""From the signals of a recording to cuts that a data set can hold."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from acf_jax.dataset import units
from acf_jax.dataset.trials import RigPrior
from acf_jax.errors import InputError
from acf_jax.recording.checks import condition_faults, force_unit_fault, interval_fault
from acf_jax.recording.contacts import Contact, Level, contact_at, find_contacts, sampling_interval
from acf_jax.recording.cut import Cut, cut_trace, group, impact_peak, remarks, spread
from acf_jax.recording.mapping import Contacts
from acf_jax.recording.review import Entry
from acf_jax.recording.session import Session
from acf_jax.recording.velocity import Estimate, pretension_at, velocity_at

UNKNOWN = Estimate(float("nan"), float("nan"))
LEAST = 3  # trials of a data set
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
        raise InputError(fault)
    where = f"{session.path} {session.labels['force']}"
    level, found = find_contacts(session.force, options, where)
    named = [(f"t{i:03d}", contact, None) for i, contact in enumerate(found)]
    chosen = named if review is None else _reviewed(session, found, review)
    cuts = _measured(session, chosen, options, known.impact_time)
    if faults := condition_faults(session, [c for c in cuts if c.keep] or cuts):
        raise InputError(faults)
    kept = [cut for cut in cuts if cut.keep]
    if len(kept) < LEAST:
        reasons = "; ".join([f"{c.trial}: {', '.join(c.remarks)}" for c in cuts if c.remarks][:5])
        more = f" ({reasons})" if reasons else ""
        raise InputError(
            f"{where}: {len(kept)} contacts of {len(cuts)} can be used{more}; a data set needs at least {LEAST}:"
            " record more"
        )
    if fault := force_unit_fault(session, kept, known):
        raise InputError(fault)
    velocity, pretension = [c.velocity for c in kept], [c.pretension for c in kept]
    v_e, f_p = group(velocity), group(pretension)
    conditions = iter(zip(v_e.tolist(), f_p.tolist(), strict=True))
    cuts = [replace(cut, condition=next(conditions)) if cut.keep else cut for cut in cuts]
    return Impacts(
        session,
        level,
        tuple(cuts),
        spread(velocity, v_e),
        spread(pretension, f_p),
        _notes(session, kept, options),
    )


def _reviewed(
    session: Session, found: Sequence[Contact], review: Sequence[Entry]
) -> list[tuple[str, Contact, bool | None]]:
    """The contacts at the times of the review, in order; a time that was found is that contact."""
    force = session.force
    step = sampling_interval(force)
    begins = np.array([contact.begin for contact in found])
    chosen: list[tuple[str, Contact, bool | None]] = []
    for entry in sorted(review, key=lambda e: e.contact_s):
        begin = int(force.time[0]) + round(1e9 * entry.contact_s)
        near = int(np.argmin(np.abs(begins - begin)))
        if abs(int(begins[near]) - begin) <= _SAME:
            chosen.append((entry.trial, found[near], entry.keep))
            continue
        first = min(int(np.searchsorted(force.time, begin)), force.time.size - 1)
        later = begins[begins > begin + 1e9 * step]
        end = int(np.searchsorted(force.time, later[0])) if later.size else force.time.size
        stop = max(min([c.stop for c in found if c.first <= first < c.stop] or [end]), first + 1)
        last = max([c.stop for c in found if c.stop <= first], default=0)
        own = contact_at(force, first, stop, last, step)
        chosen.append((entry.trial, replace(own, begin=begin, first=first), entry.keep))
    return chosen


def _measured(
    session: Session,
    chosen: Sequence[tuple[str, Contact, bool | None]],
    options: Contacts,
    impact_time: float,
) -> list[Cut]:
    """The cuts; without a user's decision those are kept of which nothing odd is known."""
    typical = float(np.median([contact.rise for _, contact, _ in chosen]))
    ends = [*(contact.first - 1 for _, contact, _ in chosen[1:]), session.force.time.size]
    cuts = []
    for (trial, contact, keep), limit in zip(chosen, ends, strict=True):
        time, force = cut_trace(session.force, contact, max(limit, contact.first + 1), options)
        velocity = _velocity(session, contact.begin)
        pretension = _pretension(session, contact.begin)
        cut = Cut(trial, True, contact, time, force, velocity or UNKNOWN, pretension or UNKNOWN)
        why = remarks(cut, typical)
        why += ["no speed was recorded before it"] if velocity is None else []
        why += ["no pretension was recorded before it"] if pretension is None else []
        peak = impact_peak(cut, impact_time, options.tare) if time.size > 3 else None
        why += ["no impact is seen in it"] if peak is None else []
        usable = velocity is not None and pretension is not None and time.size > 3
        cuts.append(
            replace(cut, keep=usable and (not why if keep is None else keep), peak=peak, remarks=tuple(why))
        )
    return cuts


def _velocity(session: Session, begin: int) -> Estimate | None:
    if isinstance(session.speed, float):
        return Estimate(session.speed, 0.0)
    return velocity_at(session.speed, session.is_position, begin)


def _pretension(session: Session, begin: int) -> Estimate | None:
    if isinstance(session.pretension, float):
        return Estimate(session.pretension, 0.0)
    return pretension_at(session.pretension, begin)


def _notes(session: Session, kept: Sequence[Cut], options: Contacts) -> tuple[str, ...]:
    notes = list(session.notes)
    offset = float(np.median([cut.contact.offset for cut in kept]))
    noise = float(np.median([cut.contact.noise_std for cut in kept]))
    rise = float(np.median([cut.contact.rise for cut in kept]))
    if abs(offset) > max(3.0 * noise, 0.02 * rise) and not options.tare:
        notes.append(
            f"the force reads {offset:.3g} N before contact; contacts: {{tare: true}} in the mapping subtracts it"
        )
    if doubtful := [cut.trial for cut in kept if cut.remarks]:
        notes.append(f"kept although doubtful: {', '.join(doubtful)}")
    return tuple(notes)

"""What is measured at each contact of a recording: its trace, speed, pretension and peak, and what is odd about it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from acf_jax.recording.checks import LEAST_SHARE
from acf_jax.recording.contacts import Contact, first_impact, sampling_interval
from acf_jax.recording.cut import Cut, cut_trace, ends_early, impact_peak, remarks
from acf_jax.recording.mapping import Contacts
from acf_jax.recording.session import Session
from acf_jax.recording.velocity import Estimate, pretension_at, velocity_at

UNKNOWN = Estimate(float("nan"), float("nan"))
_STALE = 3.0, 0.05  # sampling intervals, and s, that the last speed before a contact may be old


def first_impacts(session: Session, found: Sequence[Contact], impact_time: float) -> list[Contact]:
    """The contacts, each from its first rise that can be an impact. `impact_time`: roughly, s."""
    step = sampling_interval(session.force)
    least = [LEAST_SHARE * max((_pretension(session, c.begin) or UNKNOWN).value, 0.0) for c in found]
    return [
        first_impact(session.force, contact, n, 3.0 * impact_time, step)
        for contact, n in zip(found, least, strict=True)
    ]


def measured(
    session: Session,
    chosen: Sequence[tuple[str, Contact, bool | None]],
    options: Contacts,
    impact_time: float,
) -> list[Cut]:
    """The cuts; without a user's decision those are kept of which nothing odd is known."""
    typical = float(np.median([contact.rise for _, contact, _ in chosen]))
    step = sampling_interval(session.force)
    patience = _patience(session)
    ends = [*(contact.first - 1 for _, contact, _ in chosen[1:]), session.force.time.size]
    cuts = []
    for (trial, contact, keep), limit in zip(chosen, ends, strict=True):
        time, force = cut_trace(session.force, contact, max(limit, contact.first + 1), options)
        velocity = _velocity(session, contact.begin)
        pretension = _pretension(session, contact.begin)
        cut = Cut(trial, True, contact, time, force, velocity or UNKNOWN, pretension or UNKNOWN)
        why = remarks(cut, typical, step)
        why += ["no speed was recorded before it"] if velocity is None else _stale(session, contact, patience)
        why += ["no pretension was recorded before it"] if pretension is None else []
        peak = impact_peak(cut, impact_time, options.tare) if time.size > 3 else None
        why += ["no impact is seen in it"] if peak is None else []
        if peak is not None and ends_early(cut, impact_time):
            why.append(
                f"its trace ends {1e3 * cut.trace.time[-1]:.3g} ms after contact, while the force rises"
            )
        usable = velocity is not None and pretension is not None and time.size > 3
        cuts.append(
            replace(cut, keep=usable and (not why if keep is None else keep), peak=peak, remarks=tuple(why))
        )
    return cuts


def weighed(cuts: Sequence[Cut], decided: bool, options: Contacts) -> list[Cut]:
    """The cuts, without those whose peak is far below their pretension unless the user has `decided`."""
    done = []
    for cut in cuts:
        height = np.inf if cut.peak is None else cut.peak - (0.0 if options.tare else cut.contact.offset)
        if height < LEAST_SHARE * cut.pretension.value:
            why = f"its peak of {height:.3g} N is far below the pretension of {cut.pretension.value:.3g} N"
            cut = replace(cut, keep=cut.keep and decided, remarks=(*cut.remarks, why))
        done.append(cut)
    return done


def _patience(session: Session) -> float:
    """How old the last speed before a contact may be, s."""
    intervals, least = _STALE
    interval = 0.0 if isinstance(session.speed, float) else sampling_interval(session.speed)
    return max(intervals * interval, least)


def _stale(session: Session, contact: Contact, patience: float) -> list[str]:
    """What to remark where the last speed before a contact is older than `patience`, s."""
    if isinstance(session.speed, float):
        return []
    last = int(session.speed.time[np.searchsorted(session.speed.time, contact.begin) - 1])
    late = 1e-9 * (contact.begin - last)
    return [f"the last speed before it is {1e3 * late:.3g} ms old"] if late > patience else []


def _velocity(session: Session, begin: int) -> Estimate | None:
    if isinstance(session.speed, float):
        return Estimate(session.speed, 0.0)
    return velocity_at(session.speed, session.is_position, begin)


def _pretension(session: Session, begin: int) -> Estimate | None:
    if isinstance(session.pretension, float):
        return Estimate(session.pretension, 0.0)
    return pretension_at(session.pretension, begin)

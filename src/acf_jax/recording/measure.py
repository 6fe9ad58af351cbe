"""What is measured at each contact of a recording: its trace, speed, pretension and peak, and what is odd about it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from acf_jax.dataset import units
from acf_jax.dataset.trials import RobotVelocity
from acf_jax.recording.checks import LEAST_SHARE, is_below_zero, nought_of
from acf_jax.recording.contacts import Contact, first_impact, sampling_interval
from acf_jax.recording.cut import Cut, cut_trace, ends_early, impact_peak, remarks, zeros
from acf_jax.recording.level import BLOCK
from acf_jax.recording.mapping import Contacts
from acf_jax.recording.session import Session
from acf_jax.recording.velocity import (
    WINDOWS,
    Character,
    Estimate,
    character_of,
    motion_over,
    pretension_at,
    velocity_at,
)

OFTEN = 0.5  # of an impact, between two velocities at most: fewer do not tell how the robot moves in it
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
    character = Character()
    if not isinstance(session.speed, float):
        first = int(np.searchsorted(session.speed.time, chosen[0][1].begin - round(1e9 * WINDOWS[0])))
        character = character_of(session.speed.at(slice(first, first + BLOCK)), session.is_position)
    ends = [*(contact.first - 1 for _, contact, _ in chosen[1:]), session.force.time.size]
    cuts = []
    zero_of = zeros([contact for _, contact, _ in chosen]) if options.tare else [0.0] * len(chosen)
    for (trial, contact, keep), limit, zero in zip(chosen, ends, zero_of, strict=True):
        time, force = cut_trace(session.force, contact, max(limit, contact.first + 1), options, zero)
        velocity = _velocity(session, contact.begin, character)
        pretension = _pretension(session, contact.begin)
        cut = Cut(trial, True, contact, time, force, velocity or UNKNOWN, pretension or UNKNOWN, zero)
        why = remarks(cut, typical, step, options.separation_s)
        why += ["no speed was recorded before it"] if velocity is None else _stale(session, contact, patience)
        why += ["no pretension was recorded before it"] if pretension is None else []
        peak = impact_peak(cut, impact_time) if time.size > 3 else None
        why += ["no impact is seen in it"] if peak is None else []
        if peak is not None and ends_early(cut, impact_time):
            why.append(
                f"its trace ends {1e3 * cut.trace.time[-1]:.3g} ms after contact, while the force rises"
            )
        cut = replace(cut, motion=_motion(session, cut, character, impact_time))
        usable = velocity is not None and pretension is not None and time.size > 3
        cuts.append(
            replace(cut, keep=usable and (not why if keep is None else keep), peak=peak, remarks=tuple(why))
        )
    return cuts


def weighed(cuts: Sequence[Cut], decided: bool) -> list[Cut]:
    """The cuts; those that no data set can hold, or that cannot be right beside the others, only where `decided`."""
    nought = nought_of([cut.pretension for cut in cuts])
    done = []
    for cut in cuts:
        height = np.inf if cut.peak is None else cut.peak - cut.offset
        f_p, v_e = cut.pretension, cut.velocity.value
        why = []
        if height < LEAST_SHARE * f_p.value:
            why.append(f"its peak of {height:.3g} N is far below the pretension of {f_p.value:.3g} N")
        if v_e > units.VELOCITY.high:
            why.append(f"the velocity of {v_e:.4g} m/s is beyond {units.VELOCITY.high:g} m/s")
        if f_p.value > units.PRETENSION.high:
            why.append(f"the pretension of {f_p.value:.4g} N is beyond {units.PRETENSION.high:g} N")
        if is_below_zero(f_p, nought):
            why.append(f"the pretension is {f_p.value:.4g} N")
        done.append(replace(cut, keep=cut.keep and (decided or not why), remarks=(*cut.remarks, *why)))
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


def _motion(session: Session, cut: Cut, character: Character, impact_time: float) -> RobotVelocity | None:
    """How the robot moved over a cut; None unless its velocity was measured, on the force's clock and often enough."""
    speed, known = session.speed, character.steady == np.inf
    if isinstance(speed, float) or session.is_position or not known or not cut.time.size:
        return None
    motion = motion_over(speed, cut.contact.begin, float(cut.trace.time[-1]))
    if motion is None or units.motion_fault(motion, cut.velocity.value, OFTEN * impact_time):
        return None
    return motion if session.clock_std < motion.step else None


def _velocity(session: Session, begin: int, character: Character) -> Estimate | None:
    if isinstance(session.speed, float):
        return Estimate(session.speed, 0.0)
    found = velocity_at(session.speed, session.is_position, begin, character)
    if found is None or not session.clock_std:
        return found
    # the clock was told by the robot slowing down, so contact may lie earlier but not later
    early = velocity_at(session.speed, session.is_position, begin - round(1e9 * session.clock_std), character)
    off = 0.0 if early is None else early.value - found.value
    return Estimate(found.value, float(np.hypot(found.std, off)))


def _pretension(session: Session, begin: int) -> Estimate | None:
    if isinstance(session.pretension, float):
        return Estimate(session.pretension, 0.0)
    return pretension_at(session.pretension, begin)

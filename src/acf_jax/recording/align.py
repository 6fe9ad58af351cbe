"""The clock of a robot's log that is a file of its own, told by where the robot slows down: at the contacts.

Two files have no recorder in common. But a robot that meets the part stops or turns back soon after, so the times at
which its approaches end are those of the contacts, shifted. The shift at which the most contacts have such an end
counts. Where contacts follow each other evenly several shifts may do: then peaks tell, which grow with the speed.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import correlate
from scipy.stats import theilslopes

from acf_jax.dataset.noise import robust_std
from acf_jax.errors import InputError
from acf_jax.recording.approach import Travel, travel_of
from acf_jax.recording.contacts import Contact
from acf_jax.recording.series import Array, Nanoseconds, Series
from acf_jax.recording.session import Session

LEAST = 3  # contacts that tell a clock
_STEPS = 8  # shifts tried in the width of a travel
_SHIFTS = 12  # of each sign that are looked at
_SLOWEST = 0.02  # of the fastest speed, that an approach has
_MARGIN = 1.0, 0.15  # contacts, and share of them, that the right shift may explain fewer of than another
_CLEARLY, _SCATTER = (
    2.0,
    0.03,
)  # times that peaks scatter more at a wrong shift; relative scatter that says nothing
_DIFFER = (
    1.5,
    0.15,
    0.7,
)  # times that speeds differ, share by which peaks do, and share of that which is unexplained
_SAME = 0.05  # relative, of conditions between which no choice is needed
_DELAY = 0.1  # s after contact by which a robot slows down
_SET = 10**17  # ns; later times are those of clocks that were set
_DRIFTS = 8  # contacts that tell a drift
_REMEDY = "state clock_offset_s, s to add to its times, in the --mapping file"


@dataclass(frozen=True)
class _Shift:
    """A shift of the robot's times that may be the right one."""

    value: float  # s, of its clock ahead of that of the force
    support: int  # contacts at which an approach ends
    speeds: Array  # m/s before each contact; NaN where the robot did not approach
    pretensions: Array  # N
    misfit: float  # relative scatter of the peaks about what speed and pretension explain
    plain: float  # the same without regard to the speeds
    is_turned: bool  # approaches are such only with the sign of the speed turned

    @property
    def is_strange(self) -> bool:
        """Whether speeds that differ explain nothing of peaks that differ."""
        low, high = float(np.nanmin(self.speeds)), float(np.nanmax(self.speeds))
        return high > _DIFFER[0] * low and self.misfit > max(_DIFFER[1], _DIFFER[2] * self.plain)

    def is_worse(self, than: float) -> bool:
        """Whether its peaks scatter clearly more than at a misfit of `than`."""
        return self.misfit > _CLEARLY * max(than, _SCATTER)


def align(session: Session, contacts: Sequence[Contact]) -> Session:
    """The session with the signals of other recordings on the clock of the force.

    **Raises:** `InputError` when the contacts do not tell that clock, with the offsets that may be it.
    """
    if "speed" in session.apart and isinstance(session.speed, Series):
        session = _by_speed(session, session.speed, contacts)
    if "pretension" in session.apart and isinstance(session.pretension, Series):
        value = session.pretension.value
        if np.ptp(value):
            where = session.where("pretension")
            raise InputError(f"{where}: its clock is not known, and no speed beside it tells; {_REMEDY}")
        session = replace(session, pretension=float(value[0]))  # the same at any time
    return replace(session, apart=frozenset())


def drawn(session: Session) -> Session:
    """The session with the signals of unknown clock moved to begin with the force, for a figure."""
    begins = [s.time[0] for s in (session.speed, session.pretension) if isinstance(s, Series)]
    if not session.apart or not begins:
        return session
    shift = session.force.time[0] - begins[0]
    note = f"signals of unknown clock are drawn as with clock_offset_s: {1e-9 * shift:.6f}"
    return _moved(session, session.apart, lambda time: time + shift, note)


def without_apart(session: Session) -> Session:
    """The session without the samples of unknown clock, so that nothing is measured by them."""
    none = Series(np.empty(0, np.int64), np.empty(0))
    speed = none if "speed" in session.apart else session.speed
    return replace(
        session, speed=speed, pretension=none if "pretension" in session.apart else session.pretension
    )


def _moved(
    session: Session, roles: Collection[str], to: Callable[[Nanoseconds], Nanoseconds], note: str
) -> Session:
    """The session with the times of some signals changed."""
    speed, pretension = session.speed, session.pretension
    if "speed" in roles and isinstance(speed, Series):
        speed = replace(speed, time=to(speed.time))
    if "pretension" in roles and isinstance(pretension, Series):
        pretension = replace(pretension, time=to(pretension.time))
    return replace(session, speed=speed, pretension=pretension, notes=(*session.notes, note))


def _by_speed(session: Session, speed: Series, contacts: Sequence[Contact]) -> Session:
    """The session with the recording of the speed on the clock of the force."""
    where, n = session.where("speed"), len(contacts)
    if n < LEAST:
        raise InputError(
            f"{where}: its clock is not known, and {n} contacts are too few to tell it; {_REMEDY}"
        )
    travel = travel_of(speed, session.is_position)
    begins = np.array([1e-9 * contact.begin for contact in contacts])
    beside = {role for role in session.apart if session.elsewhere[role] == session.elsewhere["speed"]}
    f_p = session.pretension

    def pretensions(shift: float) -> Array:
        if not isinstance(f_p, Series):
            return np.full(n, f_p)
        times = np.rint(1e9 * (begins + ("pretension" in beside) * shift)).astype(np.int64)
        return f_p.value[np.maximum(np.searchsorted(f_p.time, times) - 1, 0)]

    shifts = _shifts(travel, begins, np.array([contact.rise for contact in contacts]), pretensions)
    are_set = min(int(speed.time[0]), int(session.force.time[0])) > _SET
    best, alike = _best(shifts, n, where, travel.width if are_set else None)
    slow = (travel.turned() if best.is_turned else travel).slowdowns(begins + best.value)
    told = np.isfinite(slow) & np.isfinite(best.speeds)
    begins, slow = begins[told], slow[told]
    if slow.size < LEAST:
        raise InputError(f"{where}: its clock is not known, and its log is too coarse to tell it; {_REMEDY}")
    session = replace(session, apart=session.apart - beside)
    at = f"{slow.size} of {n}"
    if are_set and _is_near(best, travel.width):
        late = 1e3 * float(np.median(slow - begins))
        note = f"{where}: its clock is that of the force: its speed drops {late:.2g} ms after {at} contacts"
        return replace(session, notes=(*session.notes, note))
    offset, drift, std = _clock(begins, slow, travel.step)
    note = (
        f"{where}: its clock is {abs(offset):.{max(-int(np.floor(np.log10(std))), 0)}f} s"
        f" {'ahead of' if offset > 0 else 'behind'} that of the force"
        + (f" and drifts by {1e6 * drift:+.3g} us/s" if drift else "")
        + f", if the robot slows down at contact, as at {at} (standard deviation {1e3 * std:.2g} ms)"
        + (f"; {alike} other shifts may be right too, and give the same conditions" if alike else "")
        + "; shifted, unless clock_offset_s is stated"
    )

    def moved(time: Nanoseconds) -> Nanoseconds:
        ahead = offset + drift * (1e-9 * time - offset - begins[0])
        return np.asarray(time - np.rint(1e9 * ahead).astype(np.int64))

    return replace(_moved(session, beside, moved, note), clock_std=std)


def _shifts(
    travel: Travel, begins: Array, rises: Array, pretensions: Callable[[float], Array]
) -> list[_Shift]:
    """The shifts at which the most contacts have an end of an approach, with either sign of the speed."""
    step = travel.width / _STEPS
    grid = np.arange(travel.time[0], travel.time[-1] + step, step)
    fastest = float(np.quantile(np.abs(travel.speed(grid - travel.width, grid)), 0.95))
    slowest = max(_SLOWEST * fastest, 1e-4)
    comb = np.zeros(round((begins[-1] - begins[0]) / step) + 1)
    comb[np.rint((begins - begins[0]) / step).astype(int)] = 1.0
    found = []
    for is_turned in (False, True):
        one = travel.turned() if is_turned else travel
        support = correlate(one.ends(grid, slowest), comb, "full", "fft")
        for _ in range(_SHIFTS):
            top = int(np.argmax(support))
            if support[top] < 1.0:
                break
            near = (
                grid[0] - begins[0] + (top - comb.size + 1) * step + np.linspace(-step, step, 2 * _STEPS + 1)
            )
            ends = np.array([one.ends(begins + value, slowest) for value in near])
            right = int(np.argmax(ends.sum(1)))
            is_end = ends[right] > 0.5
            early = begins + near[right] - 0.5 * travel.width
            speeds = np.where(is_end, one.speed(early - travel.width, early), np.nan)
            f_p = pretensions(float(near[right]))
            misfit = _misfit(rises, speeds, f_p)
            plain = (
                _misfit(rises, np.where(is_end, np.median(speeds[is_end]), np.nan), f_p)
                if is_end.any()
                else np.inf
            )
            found.append(_Shift(float(near[right]), int(is_end.sum()), speeds, f_p, misfit, plain, is_turned))
            support[max(top - 2 * _STEPS, 0) : top + 2 * _STEPS + 1] = 0.0
    return found


def _misfit(rises: Array, speeds: Array, pretensions: Array) -> float:
    """How peaks scatter about those of a mass on a spring, sqrt(F_P^2 + k m v^2), at the best k m and to a factor."""
    used = np.isfinite(speeds) & (rises > 0.0)
    if np.count_nonzero(used) < LEAST:
        return np.inf
    impedance = np.geomspace(30.0, 3e4, 91)[:, None]  # sqrt(k m), N s/m
    expected = np.hypot(pretensions[used], impedance * speeds[used])
    return float(np.log(rises[used] / expected).std(1).min())


def _best(shifts: Sequence[_Shift], n: int, where: str, zero: float | None) -> tuple[_Shift, int]:
    """The shift that is right, and how many others may be as well but lead to the same conditions.

    **Arguments:** `n`: contacts. `zero`: s, how near to none the shift of one and the same clock is; None: of clocks
    that were never set.

    **Raises:** `InputError` when none explains enough contacts, or several do that lead to other conditions.
    """
    most = max((shift.support for shift in shifts), default=0)
    if most < max(LEAST, n / 2):
        raise InputError(
            f"{where}: its clock is not known, and its speed drops at {most} of {n} contacts at best; {_REMEDY},"
            " or name the log of this session"
        )
    # one that leaves no contact out is better than any that does
    margin = 0.0 if most == n else max(_MARGIN[0], _MARGIN[1] * n)
    able = sorted((s for s in shifts if s.support >= most - margin), key=lambda s: (s.is_turned, -s.support))
    best = able[0]
    if better := [s for s in able if best.is_worse(s.misfit)]:
        best = max(better, key=lambda s: s.support)
    for one in able:
        if zero is not None and not one.is_turned and _is_near(one, zero) and not one.is_worse(best.misfit):
            return one, 0
    if best.is_strange:
        raise InputError(
            f"{where}: its clock is not known, and where its speed drops at the most contacts it does not go with the"
            f" peaks of the force; {_REMEDY}, or name the log of this session"
        )
    also = [
        s for s in able if s is not best and s.is_turned == best.is_turned and not s.is_worse(best.misfit)
    ]
    if rivals := [s for s in also if not _is_like(s, best)]:
        others = " or ".join(f"{-s.value:.2f}" for s in [best, *rivals][:4])
        raise InputError(
            f"{where}: its clock is not known, as contacts that follow each other evenly fit to it at several shifts;"
            f" {_REMEDY}: about {others}"
        )
    return best, len(also)


def _is_near(shift: _Shift, width: float) -> bool:
    """Whether the clocks are one: the robot slows down soon after contact."""
    return -0.5 * width <= shift.value <= _DELAY + width


def _is_like(other: _Shift, best: _Shift) -> bool:
    """Whether another shift leads to the same conditions."""
    both = np.isfinite(other.speeds) & np.isfinite(best.speeds)
    pairs = ((other.speeds, best.speeds), (other.pretensions, best.pretensions))
    return all(bool((np.abs(a - b)[both] <= _SAME * np.abs(b)[both]).all()) for a, b in pairs)


def _clock(begins: Array, slow: Array, step: float) -> tuple[float, float, float]:
    """Offset (s) and drift (s/s) of the robot's clock, and the standard deviation of the offset (s).

    **Arguments:** `begins`: of contacts, s. `slow`: when the robot begins to slow down, s, by its clock. `step`: its
    sampling interval, s.
    """
    late, drift = slow - begins, 0.0
    if late.size >= _DRIFTS:
        slope, _, low, high = theilslopes(late, begins, alpha=0.99)
        drift = float(slope) if low * high > 0.0 else 0.0
    rest = late - drift * (begins - begins[0])
    middle = float(np.median(rest))
    std = max(robust_std(rest - middle), step / 12**0.5)
    # no robot slows down before contact: the earliest that is no outlier counts
    return float(rest[rest >= middle - 3.0 * std].min()), drift, std

"""Units and signs that cannot be right, named with their remedy."""

from collections.abc import Sequence

import numpy as np

from acf_jax.dataset import units
from acf_jax.dataset.trials import RigPrior
from acf_jax.recording.contacts import APPROACH, Contact, sampling_interval
from acf_jax.recording.cut import Cut
from acf_jax.recording.onset import SURE
from acf_jax.recording.rate import IN_MS, advised_rate, too_slow
from acf_jax.recording.sampling import sampling_fault
from acf_jax.recording.series import Array
from acf_jax.recording.session import Session
from acf_jax.recording.velocity import Estimate
from acf_jax.si import UNITS

FASTEST = 2e6  # Hz, beyond any force sensor
NOUGHT = 0.01  # of the largest pretension, that a sensor may read below none at all
LEAST_SHARE = 0.4  # of the pretension that a first peak reaches at least
FAR = 8.0  # times the expected peaks, which no rig reaches
SOFT = 1 / 64  # of them, which every rig exceeds: 0.5 kg and 1e4 N/m give 1/13 of a typical rig's
UNDECIDED = 1.5  # a factor within which two slips explain the same peaks as well
NEWTONS = {unit: UNITS["force"][unit] for unit in ("kN", "kgf", "gf", "mN")}  # taken for newtons


def interval_faults(session: Session, impact_time: float) -> list[str]:
    """Why the times of the force cannot be in seconds, if they cannot. `impact_time`: roughly, s."""
    if session.force.time.size < 2:
        return []  # too short for another reason
    step = sampling_interval(session.force)
    where = session.where("force")
    if step > 3.0 * impact_time:
        return [
            f"{where}: a sample every {step:g} s, longer than a whole impact (about {impact_time:.2g} s);"
            f" {IN_MS}, else record the force faster, at {advised_rate(impact_time)}"
        ]
    if SURE * step > APPROACH:
        return [
            f"{where}: a sample every {step:g} s leaves {APPROACH / step:.0f} in the {APPROACH:g} s before a contact,"
            f" where {SURE} are needed; {too_slow(step, impact_time) or 'record the force faster'}"
        ]
    if step < 1.0 / FASTEST:
        return [
            f"{where}: a sample every {step:g} s is beyond any sensor; set time_scale in the --mapping file to the"
            " seconds in a unit"
        ]
    fault = sampling_fault(session.force, where, impact_time)
    return [fault] if fault else []


def rise_faults(session: Session, contacts: Sequence[Contact], impact_time: float) -> list[str]:
    """Why times of so few samples an impact cannot be in seconds: force rises for far too long, and twice at least."""
    force, step = session.force, sampling_interval(session.force)
    if len(contacts) < 2 or not units.is_undersampled(step, impact_time):
        return []
    parts = [(force.at(slice(contact.first, contact.stop)), contact) for contact in contacts]
    rise = sorted(units.rise_time(part.seconds(c.begin), part.value - c.offset) for part, c in parts)[-2]
    if not units.is_slow_rise(rise, impact_time):
        return []
    return [
        f"{session.where('force')}: a sample every {step:g} s, and the force rises for {rise:.3g} s, where an impact"
        f" lasts about {impact_time:.2g} s; {IN_MS}"
    ]


def condition_faults(session: Session, cuts: Sequence[Cut]) -> list[str]:
    """What is wrong with the measured speeds and pretensions of the contacts as a whole."""
    faults = []
    speeds = [cut.velocity.value for cut in cuts if np.isfinite(cut.velocity.value)]
    where = session.where("speed")
    kind = "position" if session.is_position else "velocity"
    middle = float(np.median(speeds)) if speeds else 0.0
    if not speeds:
        faults.append(
            f"{where}: has no samples before any contact; state clock_offset_s, s to add, if its clock is another"
        )
    elif middle < -1e-4:
        faults.append(
            f"{where}: the robot moves at {middle:.4g} m/s before contact, away from the part;"
            f" {session.remedy('speed', -1.0)}, or state clock_offset_s if its clock is another"
        )
    elif middle > units.VELOCITY.high:
        unit = "mm" if session.is_position else "mm/s"
        faults.append(
            f"{where}: the {kind} gives {middle:.4g} m/s before contact; if it is in {unit},"
            f" {session.remedy('speed', 0.001)}"
        )
    elif middle < 1e-4:
        faults.append(
            f"{where}: the robot stands still before contact ({middle:.2g} m/s); name another axis or signal, or"
            " state clock_offset_s if its clock is another"
        )
    found = [cut.pretension for cut in cuts if np.isfinite(cut.pretension.value)]
    nought = nought_of(found)
    pretensions = [0.0 if is_none(one, nought) else one.value for one in found]
    negative = [one.value for one in found if is_below_zero(one, nought)]
    where = session.where("pretension")
    if not pretensions:
        faults.append(f"{where}: has no value before any contact; give the pretension in N by --pretension")
    elif 2 * len(negative) >= len(pretensions):
        faults.append(
            f"{where}: the pretension is {min(negative):.4g} N; {session.remedy('pretension', -1.0)}"
        )
    elif fault := units.PRETENSION.fault(
        max(float(np.median(pretensions)), 0.0)
    ) or units.pretension_column_fault(pretensions):
        faults.append(f"{where}: {fault}")
    return faults


def nought_of(pretensions: Sequence[Estimate]) -> float:
    """What a sensor may read where the pretension is none, N; of small readings of both signs all of it is noise."""
    values = [pretension.value for pretension in pretensions]
    low, high = min(values, default=0.0), max(values, default=0.0)
    is_noise = low < 0.0 < high < units.LEAST_PRETENSION and low > -units.LEAST_PRETENSION
    return units.LEAST_PRETENSION if is_noise else NOUGHT * high


def is_none(pretension: Estimate, nought: float) -> bool:
    """Whether a pretension is none at all, within its scatter or `nought`, N."""
    value = abs(pretension.value)
    return value < units.LEAST_PRETENSION and value <= max(3.0 * pretension.std, nought)


def is_below_zero(pretension: Estimate, nought: float) -> bool:
    """Whether a pretension is below zero by more than its scatter and than `nought`, what a sensor may err by, N."""
    return pretension.value < -max(3.0 * pretension.std, nought)


def force_unit_fault(session: Session, cuts: Sequence[Cut], rig: RigPrior) -> str | None:
    """Why force or pretension cannot be in newtons, against the peaks that a rig like `rig` would give.

    Of the slips that there are those are named that bring the peaks closest to the expected ones.
    """
    peaks = np.array([cut.contact.rise for cut in cuts])
    f_p, v_e = (np.array([getattr(cut, name).value for cut in cuts]) for name in ("pretension", "velocity"))

    def expected(f_p: Array) -> Array:
        return np.maximum(rig.undamped_peak(v_e, f_p), 1e-9)

    def ratio(peaks: Array, f_p: Array) -> float:
        """Of peaks to the expected ones; zero where they stay too far below the pretension."""
        is_low = np.median(peaks - LEAST_SHARE * f_p) < 0.0
        return 0.0 if is_low else float(np.median(peaks / expected(f_p)))

    if SOFT < ratio(peaks, f_p) <= FAR:
        return None
    slips = [
        (ratio(n * peaks, f_p), f"the force is in {unit}, {session.remedy('force', n)}")
        for unit, n in NEWTONS.items()
    ]
    slips += [
        (ratio(peaks, n * f_p), f"the pretension is in {unit}, {session.remedy('pretension', n)}")
        for unit, n in NEWTONS.items()
    ]
    off = {text: abs(float(np.log(r))) for r, text in slips if r > 0.0}
    least = min(off.values(), default=np.inf)
    likely = [text for text, o in off.items() if o < min(least + np.log(UNDECIDED), np.log(FAR))]
    return (
        f"{session.where('force')}: peaks of {float(np.median(peaks)):.3g} N do not go with a"
        f" pretension of {float(np.median(f_p)):.3g} N and {float(np.median(v_e)):.3g} m/s (about"
        f" {float(np.median(expected(f_p))):.3g} N); "
        + (", or ".join(f"if {text}" for text in likely) or "look at the scale and the axis of each")
    )

"""Units and signs that cannot be right, named with their remedy."""

from collections.abc import Sequence

import numpy as np

from acf_jax.dataset import units
from acf_jax.dataset.trials import RigPrior
from acf_jax.recording.contacts import sampling_interval
from acf_jax.recording.cut import Cut
from acf_jax.recording.session import Session

FASTEST = 2e6  # Hz, beyond any force sensor
LEAST_SHARE = 0.4  # of the pretension that a first peak reaches at least
FAR = 8.0  # a factor between peaks and those expected that no rig explains
# What a force in another unit is times too large, and the scale that mends it.
FORCE_UNITS = {
    "kN": (1e-3, 1e3),
    "kgf": (1 / 9.80665, 9.80665),
    "gf": (101.97, 9.80665e-3),
    "mN": (1e3, 1e-3),
}


def interval_fault(session: Session, impact_time: float) -> str | None:
    """Why the times of the force cannot be in seconds; None when they can. `impact_time`: roughly, s."""
    if session.force.time.size < 2:
        return None  # too short for another reason
    step = sampling_interval(session.force)
    where = f"{session.path} {session.labels['force']}"
    if step > 3.0 * impact_time:
        return (
            f"{where}: a sample every {step:g} s, longer than a whole impact (about {impact_time:.2g} s);"
            " if its times are in ms, set time_scale: 1.0e-3 (us: 1.0e-6, ns: 1.0e-9), else record faster"
        )
    if step < 1.0 / FASTEST:
        return f"{where}: a sample every {step:g} s is beyond any sensor; set time_scale to the seconds in a unit"
    return None


def condition_faults(session: Session, cuts: Sequence[Cut]) -> list[str]:
    """What is wrong with the measured speeds and pretensions of the contacts as a whole."""
    faults = []
    speeds = [cut.velocity.value for cut in cuts if np.isfinite(cut.velocity.value)]
    where = f"{session.path} {session.labels.get('speed', '--velocity')}"
    kind = "position" if session.is_position else "velocity"
    middle = float(np.median(speeds)) if speeds else 0.0
    if not speeds:
        faults.append(
            f"{where}: has no samples before any contact; state clock_offset_s, s to add, if its clock is another"
        )
    elif middle < -1e-4:
        faults.append(
            f"{where}: the robot moves at {middle:.4g} m/s before contact, away from the part; put -1* before its name"
        )
    elif middle > units.VELOCITY.high:
        unit = "mm" if session.is_position else "mm/s"
        faults.append(
            f"{where}: the {kind} gives {middle:.4g} m/s before contact; if it is in {unit}, put 0.001* before its name"
        )
    elif middle < 1e-4:
        faults.append(
            f"{where}: the robot stands still before contact ({middle:.2g} m/s); name another axis or signal, or"
            " state clock_offset_s if its clock is another"
        )
    pretensions = [cut.pretension.value for cut in cuts if np.isfinite(cut.pretension.value)]
    where = f"{session.path} {session.labels.get('pretension', '--pretension')}"
    if not pretensions:
        faults.append(f"{where}: has no value before any contact; give the pretension in N by --pretension")
    elif min(pretensions) < 0.0:
        faults.append(f"{where}: the pretension is {min(pretensions):.4g} N; put -1* before its name")
    elif fault := units.PRETENSION.fault(max(pretensions)) or units.pretension_column_fault(pretensions):
        faults.append(f"{where}: {fault}")
    return faults


def force_unit_fault(session: Session, cuts: Sequence[Cut], rig: RigPrior) -> str | None:
    """Why the force cannot be in newtons, against pretensions and the peaks that a rig like `rig` would give."""
    peaks = np.array([cut.contact.rise for cut in cuts])
    f_p, v_e = (np.array([getattr(cut, name).value for cut in cuts]) for name in ("pretension", "velocity"))
    expected = np.sqrt(f_p**2 + rig.k_c.value * rig.m.value * v_e**2)
    ratio = float(np.median(peaks / np.maximum(expected, 1e-9)))
    share = float(np.median(peaks / np.maximum(f_p, 1e-9)))
    low = (f_p.max() > 0.0 and share < LEAST_SHARE) or ratio < 1.0 / FAR**2
    if not (low or ratio > FAR):
        return None
    unit, (_, scale) = min(FORCE_UNITS.items(), key=lambda item: abs(np.log(item[1][0] / max(ratio, 1e-12))))
    return (
        f"{session.path} {session.labels['force']}: peaks of {float(np.median(peaks)):.3g} N do not go with a"
        f" pretension of {float(np.median(f_p)):.3g} N and {float(np.median(v_e)):.3g} m/s (about"
        f" {float(np.median(expected)):.3g} N); if the force is in {unit}, put {scale:g}* before its name"
    )

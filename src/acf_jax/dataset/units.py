"""Limits beyond which a number is in the wrong unit, set far outside what a flange can be.

The limits leave at least a factor of five around rigs seen in practice (0.5 to 10 kg, 1e4 to 1e6 N/m,
0.01 to 1 m/s, up to 500 N), and still catch the usual slips: mm/s, ms, kN, N/mm, g, percent.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from acf_jax.dataset.noise import robust_std
from acf_jax.dataset.trials import Array, LowPass, Prior, RigPrior, RobotVelocity, Trace, Trial
from acf_jax.documents import is_number
from acf_jax.errors import shown


@dataclass(frozen=True)
class Limit:
    """The range that a quantity can lie in, and the likely slip on either side."""

    unit: str  # empty for a share
    low: float
    high: float
    too_low: str = ""
    too_high: str = ""

    def fault(self, value: float) -> str | None:
        """Why `value` cannot be right, with the remedy; None when it can."""
        unit = f" {self.unit}" if self.unit else ""
        usual = f"give it in {self.unit}" if self.unit else "give it as a share"
        if not math.isfinite(value):
            return f"must be a finite number, but is {value}; {usual}"
        if value < self.low:
            remedy = self.too_low if self.too_low and value > 0 else usual
            return f"must be at least {self.low:g}{unit}, but is {value:g}; {remedy}"
        if value > self.high:
            return f"must be at most {self.high:g}{unit}, but is {value:g}; {self.too_high or usual}"
        return None


MASS = Limit("kg", 0.02, 100.0, "if it is in tonnes, multiply by 1000", "if it is in g, divide by 1000")
DAMPING = Limit("N s/m", 0.0, 1e5)
ACTUATOR_STIFFNESS = Limit("N/m", 0.0, 1e7)
CONTACT_STIFFNESS = Limit(
    "N/m", 2e3, 1e9, "if it is in N/mm, multiply by 1000", "if it is in mN/m, divide by 1000"
)
VELOCITY = Limit("m/s", 1e-5, 5.0, "if it is in km/s, multiply by 1000", "if it is in mm/s, divide by 1000")
PRETENSION = Limit("N", 0.0, 5e3, too_high="if it is in gf, multiply by 0.0098, if in mN, divide by 1000")
LEAST_PRETENSION = 1.0  # N, below which no flange is set, but to none at all
PEAK_FORCE = Limit("N", 0.1, 5e4, "if it is in kN, multiply by 1000", "if it is in mN, divide by 1000")
FORCE_LIMIT = Limit("N", 1.0, 5e4, "if it is in kN, multiply by 1000", "if it is in mN, divide by 1000")
SENSOR_RANGE = Limit("N", 1.0, 1e5, "if it is in kN, multiply by 1000", "if it is in mN, divide by 1000")
CUTOFF = Limit("Hz", 1.0, 1e6, "if it is in kHz, multiply by 1000", "if it is in mHz, divide by 1000")
FORCE_NOISE = Limit("N", 1e-6, 1e3, too_high="if it is in mN, divide by 1000")
ROBOT_VELOCITY_STD = Limit("m/s", 1e-7, 0.5, too_high="if it is in mm/s, divide by 1000")
RELATIVE_STD = Limit("", 0.0, 0.25, too_high="if it is in percent, divide by 100")

# By the names of the commands' files and options.
QUANTITIES = {
    "m": MASS,
    "d": DAMPING,
    "k_f": ACTUATOR_STIFFNESS,
    "k_c": CONTACT_STIFFNESS,
    "v_e": VELOCITY,
    "f_p": PRETENSION,
    "limit": FORCE_LIMIT,
}
MUST_BE_POSITIVE = ("m", "k_c", "limit")

# Stands in for a rig whose description is faulty, so that the units of its traces are still judged.
TYPICAL_RIG = RigPrior(Prior(4.0, 2.0), Prior(80.0, 80.0), Prior(5e3, 5e3), Prior(2e5, 1e5))

_SLOW = 50.0  # impact times: longer than a force goes on rising in seconds, shorter than in ms
_RISEN = 0.8  # of its largest value: noise on a force that lasts adds less
_CLEAR = 8.0  # times the change from sample to sample, which noise alone does not reach
_SHORTEST = 0.05  # of an impact, that a trace lasts: no rig's uncertainty explains less
_OTHER_SPEED = 3.0  # factor between stated and measured velocity at contact: another trial's, unit or axis
_BEYOND = 1.1  # times its range, that a sensor may read
_FAR = 100.0  # a factor that no rig's uncertainty explains, yet well below the 1000 of a wrong prefix


def unit_fault(name: str, value: float) -> str | None:
    """Why a value of one of `QUANTITIES` must be in another unit; None where it may be right, as zero is in any."""
    return QUANTITIES[name].fault(value) if name in QUANTITIES and value else None


def value_fault(name: str, value: Any, where: str) -> str | None:
    """What is wrong with a value of one of `QUANTITIES`, its sign or its unit, after `where`, if anything is."""
    range_ = "positive" if name in MUST_BE_POSITIVE else "zero or positive"
    if is_number(value) and (value > 0 or (value == 0 and name not in MUST_BE_POSITIVE)):
        return f"{where} {fault}" if (fault := unit_fault(name, value)) else None
    unit = QUANTITIES[name].unit
    return f"{where} must be a number, finite and {range_}, in {unit}, but is {shown(value)}; correct it"


def expected_peak(rig: RigPrior, trial: Trial) -> float:
    """Peak of the undamped impact at the rig's prior values, N."""
    return float(rig.undamped_peak(*np.array(trial.condition)))


def time_fault(trace: Trace, impact_time: float) -> str | None:
    """Why the column `time_s` cannot be in seconds from first contact; None when it can."""
    time, step = trace.time, trace.step
    if step > 3.0 * impact_time:
        return (
            f"time_s advances by {step:g} s a sample, longer than a whole impact (about {impact_time:.2g} s);"
            " if it is in ms, divide by 1000"
        )
    contact = time >= 0.0
    if contact.any() and is_undersampled(step, impact_time):
        rise = rise_time(time[contact], trace.force[contact] - _at_rest(trace)[0])
        if is_slow_rise(rise, impact_time):
            return (
                f"time_s advances by {step:g} s a sample and the force rises for {rise:.3g} s, where an impact lasts"
                f" about {impact_time:.2g} s; if it is in ms, divide by 1000"
            )
    if time[-1] <= 0.0 or time[0] > impact_time:
        return (
            f"time_s runs from {time[0]:g} to {time[-1]:g} s and misses the impact that starts at 0;"
            " shift it so that first contact is at 0"
        )
    if np.count_nonzero(time >= 0.0) < 3:
        return "has fewer than 3 samples from time 0 on; record the whole impact"
    if time[-1] < _SHORTEST * impact_time:
        return (
            f"time_s ends at {time[-1]:.3g} s, long before the impact is over (about {impact_time:.2g} s); record the"
            " whole impact, or if it is in ks, multiply by 1000"
        )
    return None


def is_undersampled(step: float, impact_time: float) -> bool:
    """Whether an impact has fewer than two samples, `step` apart; s both."""
    return 2.0 * step > impact_time


def rise_time(time: Array, force: Array) -> float:
    """From the first sample until the force, N above its rest, has nearly reached its largest value, s; 0 of noise."""
    if force.size < 2 or force.max() < _CLEAR * np.median(np.abs(np.diff(force))):
        return 0.0
    return float(time[np.argmax(force >= _RISEN * force.max())] - time[0])


def is_slow_rise(rise: float, impact_time: float) -> bool:
    """Whether a force that rises for so long, s, cannot be an impact: its times are in a smaller unit."""
    return rise > _SLOW * impact_time


def force_fault(trace: Trace, expected: float) -> str | None:
    """Why the column `force_n` cannot be in newtons, against an expected peak in N; None when it can.

    Only a clear signal is judged: a dead cable reads far too little as well, and is a faulty trial.
    """
    magnitude = np.sort(np.abs(trace.force))
    typical = float(magnitude[-3])  # a spike of one or two samples is no unit
    _, noise = _at_rest(trace)
    if 0.0 < typical < expected / _FAR and typical > 20.0 * noise and typical < 2.0:
        return f"force_n only reaches {typical:.3g} N, not about {expected:.3g} N; if in kN, multiply by 1000"
    if typical > _FAR * expected and typical > 2e4:
        return f"force_n reaches {typical:.3g} N, not about {expected:.3g} N; if in mN, divide by 1000"
    return None


def motion_fault(motion: RobotVelocity, contact_velocity: float | None, impact_time: float) -> str | None:
    """Why the robot's measured velocity cannot be that over an impact at a stated one, m/s; None when it can."""
    time, step = motion.time, motion.step
    if time[0] > 0.0 or time[-1] < 0.5 * impact_time:
        return (
            f"time_s runs from {time[0]:g} to {time[-1]:g} s; give the velocity from first contact at 0, or before, to"
            f" the end of the impact (about {impact_time:.2g} s)"
        )
    if step > impact_time:
        return (
            f"time_s advances by {step:g} s a sample, longer than an impact (about {impact_time:.2g} s): that"
            " cannot tell how the robot moves in it; leave the cell `motion` empty, or if time is in ms, divide by 1000"
        )
    near = np.argsort(np.abs(time))[:5]  # one sample alone may be noise
    there = float(np.median(motion.value[near]))
    if contact_velocity and not 1 / _OTHER_SPEED < there / contact_velocity < _OTHER_SPEED:
        return (
            f"robot_velocity_m_per_s is {there:.3g} at first contact, but contact_velocity_m_per_s is"
            f" {contact_velocity:g}; give it in m/s, positive towards the part, of the same trial"
        )
    return None


def _at_rest(trace: Trace) -> tuple[float, float]:
    """What the sensor reads before time 0 and how far that scatters, N, whatever a few odd samples do."""
    before = trace.force[trace.time < 0.0]
    if not before.size:
        return 0.0, 0.0
    rest = float(np.median(before))
    return rest, robust_std(before - rest)


def range_fault(range_n: float, trials: Sequence[Trial]) -> str | None:
    """Why the sensor's range cannot end at `range_n`, N, as some trial reads far more; None when it can."""
    # a spike of one or two samples is no range
    tops = {t.name: float(np.partition(t.trace.force, -3)[-3]) for t in trials if t.trace}
    tops |= {t.name: t.peak_force for t in trials if t.trace is None and t.peak_force is not None}
    name = max(tops, key=tops.__getitem__, default=None)
    if name is None or tops[name] <= _BEYOND * range_n:
        return None
    return (
        f"measurement.range_n: is {range_n:g} N, but trial {shown(name)} reads {tops[name]:.4g} N; give the reading at"
        " which the sensor's range ends, or leave it out"
    )


def low_pass_fault(low_pass: LowPass, impact_time: float, trials: Sequence[Trial]) -> str | None:
    """Why a filter leaves nothing to compare, or no trace can have been through it; None where neither is so."""
    cutoff = low_pass.cutoff_hz
    if fault := CUTOFF.fault(cutoff):
        return f"cutoff_hz {fault}"
    if is_undersampled(0.5 / cutoff, impact_time):  # what is left is told by samples that far apart
        return (
            f"cutoff_hz is {cutoff:g} Hz, which leaves less than two samples of an impact of"
            f" {1e3 * impact_time:.3g} ms; give at least {1 / impact_time:.3g} Hz"
        )
    rates = {t.name: 1 / t.trace.step for t in trials if t.trace}
    name = min(rates, key=rates.__getitem__, default=None)
    if name is None or cutoff < rates[name] / 2:
        return None
    return (
        f"cutoff_hz is {cutoff:g} Hz, but trial {shown(name)} is sampled at {rates[name]:.4g} Hz; give less than half"
        " of that"
    )


def sign_fault(traces: Sequence[Trace]) -> str | None:
    """Why the traces as a whole cannot count positive in compression; None when they can."""
    turned = [trace for trace in traces if _falls(trace)]
    if 2 * len(turned) <= len(traces):
        return None
    least = min(float(trace.force.min()) for trace in turned)
    return (
        f"force_n falls in contact, to {least:.4g} N, in {len(turned)} of {len(traces)} traces; force counts positive"
        " in compression: change the sign"
    )


def _falls(trace: Trace) -> bool:
    """Whether the force clearly goes down in contact and hardly up, from what it reads before."""
    rest, noise = _at_rest(trace)
    contact = np.sort(trace.force[trace.time >= 0.0]) - rest
    down, up = -float(contact[2]), max(float(contact[-3]), 0.0)  # a spike of one or two samples is no contact
    return down > max(3.0 * up, 20.0 * noise, 2.0)


def peak_fault(value: float) -> str | None:
    """Why a single `peak_force_n` cannot be right, with the remedy; None when it can."""
    if value < 0.0:
        return (
            f"must be above 0 N, but is {value:g}; force counts positive in compression: change the sign,"
            " or take off what the unloaded sensor reads"
        )
    if value == 0.0:
        return "must be above 0 N, but is 0; leave the cell empty where the peak is unknown"
    return None


def peak_column_fault(rig: RigPrior, trials: list[Trial]) -> str | None:
    """Why the column `peak_force_n` as a whole cannot be in newtons; None when it can."""
    ratios = [t.peak_force / expected_peak(rig, t) for t in trials if t.peak_force is not None]
    middle = float(np.median(ratios)) if ratios else 1.0
    if 0.0 < middle < 1.0 / _FAR:
        return f"peak_force_n is about {1 / middle:.0f} times too small; if it is in kN, multiply by 1000"
    if middle > _FAR:
        return f"peak_force_n is about {middle:.0f} times too large; if it is in mN, divide by 1000"
    return None


def pretension_column_fault(values: list[float]) -> str | None:
    """Why the column `pretension_n` as a whole cannot be in newtons; None when it can."""
    largest = max(values, default=0.0)
    if 0.0 < largest < LEAST_PRETENSION:
        return f"pretension_n is at most {largest:g} N in all rows; if it is in kN, multiply by 1000"
    return None

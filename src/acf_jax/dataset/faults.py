"""What one trace shows by itself: no signal, dropouts, stuck values, a force that is cut off.

Every test is against what the rest of the same trace does, so that ringing, which all samples share, is no fault.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from acf_jax.dataset.noise import quantisation_step
from acf_jax.dataset.phase import ImpactPhase
from acf_jax.dataset.trials import Array, Trace, Trial

SHOULDER = 3  # samples over which the slope beside a flat top is told
LONG = 5  # equal readings in a row that are worth a look


class Readings(NamedTuple):
    """How the readings of a trace differ from one to the next."""

    step: float  # N, by which they differ; 0: none seen
    equal: int  # that are the last one again
    samples: int

    @classmethod
    def of(cls, force: Array, step: float) -> "Readings":
        """Those of a force, N; `step`: its quantisation, N."""
        return cls(step, int(np.count_nonzero(np.diff(force) == 0.0)), force.size)

    def is_improbable(self, length: int, noise_std: float) -> bool:
        """Whether noise leaves no room for so many equal readings in a row.

        Two readings of noise far above the step q are equal with probability q/(2 sqrt(pi) std); a sensor that is
        read faster than it measures repeats itself more often, which the rest of the trace shows.
        """
        if noise_std <= self.step or self.step == 0.0:
            return False
        repeated = max(self.equal - (length - 1), 0) / self.samples
        equal = max(self.step / (2.0 * np.pi**0.5 * noise_std), 1.5 * repeated)
        return bool(self.samples * equal ** (length - 1) < 1e-5)


def no_impact(trial: Trial, phase: ImpactPhase | None) -> list[str]:
    """Why the trace of a trial shows no impact; empty when it does, or where there is none."""
    if trial.trace is None or (phase is not None and phase.height >= 0.3 * trial.pretension):
        return []
    return ["no impact is seen in its trace (dead sensor or cable?)"]


def peak_disagreement(trial: Trial, phase: ImpactPhase, noise_std: float) -> list[str]:
    """The peak in trials.csv against that of the trace."""
    stated, trace = trial.peak_force, trial.trace
    if stated is None or trace is None:
        return []
    # where the force nearly vanishes, whether contact was lost is open: the peak of the whole trace may be meant
    peaks = np.array([phase.peak_force, trace.force[phase.start :].max()])
    allowed = 0.05 * (peaks - phase.offset) + 6.0 * noise_std
    # as read or with the offset taken off
    near = [np.abs(stated - peaks + taken_off) <= allowed for taken_off in (0.0, phase.offset)]
    if np.any(near) or (phase.cut_off is not None and stated > phase.peak_force):
        return []
    return [f"peak_force_n is {stated:g} N, but its trace peaks at {phase.peak_force:.4g} N (wrong label?)"]


def cut_off(trace: Trace, phase: ImpactPhase, noise_std: float, readings: Readings) -> bool:
    """Whether the force stays at its largest reading although it has to go on: the sensor's range ends there.

    Its shoulders point well above the flat top, or noise leaves no room for so many equal readings.

    **Arguments:** `trace`: what the unloaded sensor reads taken off. `noise_std`: noise of one sample, N.
    `readings`: of the trace.
    """
    force = trace.force[phase.start : phase.stop]
    top, step = float(force.max()), quantisation_step(force)
    for first, last in _runs(force):
        if force[first] != top:
            continue
        slopes = []
        if first >= SHOULDER:
            slopes.append((top - force[first - SHOULDER]) / SHOULDER)
        if last + SHOULDER < force.size:
            slopes.append((top - force[last + SHOULDER]) / SHOULDER)
        length = last - first + 1
        rise = float(np.mean(slopes or [0.0])) * length / 4.0  # of a parabola with these slopes at its ends
        if rise > max(0.02 * top, 3.0 * noise_std, 3.0 * step):
            return True
        if length >= LONG and readings.is_improbable(length, noise_std):
            return True
    return False


def stuck(trace: Trace, phase: ImpactPhase, noise_std: float, readings: Readings) -> str | None:
    """One value below the top repeated although the force must have moved on, or its noise would not allow it."""
    force = trace.force[phase.start : phase.stop]
    top = float(force.max())
    changes = np.abs(np.diff(force))
    moving = float(np.median(changes))
    for first, last in _runs(force):
        value, length = float(force[first]), last - first + 1
        if length < LONG or not 0.05 * top <= value < top:
            continue
        jump = abs(float(force[last + 1]) - value) if last + 1 < force.size else 0.0
        if jump > max(0.04 * top, 8.0 * noise_std, 5.0 * moving) or readings.is_improbable(length, noise_std):
            return f"its force sticks at {value:.4g} N for {length} samples (amplifier, cable?)"
    return None


def dropout(trace: Trace, phase: ImpactPhase, noise_std: float) -> str | None:
    """A fall to nothing within one sample, from a force that had been changing slowly."""
    force = trace.force[phase.start :]
    if force.size < 8:
        return None
    top = float(force[: phase.stop - phase.start].max())
    changes = np.abs(np.diff(force))[2:]
    sudden = max(0.2 * top, 10.0 * noise_std, 5.0 * float(np.quantile(changes, 0.8)))
    nothing = max(4.0 * noise_std, 0.03 * top)
    for index in range(2, min(phase.stop - phase.start + 3, force.size - 1)):
        if force[index] - force[index + 1] > sudden and abs(force[index + 1]) < nothing:
            time = 1e3 * float(trace.time[phase.start + index + 1])
            return f"its force drops out to nothing within one sample at {time:.3g} ms (cable?)"
    return None


def _runs(values: Array) -> Iterator[tuple[int, int]]:
    """First and last index of each run of equal values of at least three samples."""
    edges = np.flatnonzero(np.diff(values) != 0.0)
    first = np.concatenate([[0], edges + 1])
    last = np.concatenate([edges, [values.size - 1]])
    for a, b in zip(first, last, strict=True):
        if b - a >= 2:
            yield int(a), int(b)

"""Faults that one trace shows by itself: no signal, dropouts, spikes, stuck and clipped values."""

from collections.abc import Iterator

import numpy as np

from acf_jax.dataset.noise import quantisation_step
from acf_jax.dataset.phase import ImpactPhase
from acf_jax.dataset.trials import Array, Trace, Trial


def trace_faults(trial: Trial, phase: ImpactPhase | None, noise_std: float, offset: float = 0.0) -> list[str]:
    """Why the trace of a trial is not to be trusted, in plain words; empty when nothing speaks against it.

    `offset`: what the unloaded sensor reads, N.

    Every test is against what the rest of the same trace does, so that ringing, which all samples share,
    is no fault.
    """
    trace = trial.trace
    if trace is None:
        return []
    if phase is None or phase.peak_force - offset < 0.3 * trial.pretension:
        return ["no impact is seen in its trace (dead sensor or cable?)"]
    # A handful of samples has no shape to judge.
    tests = (clipping, stuck, dropout, spike) if phase.stop - phase.start >= 6 else ()
    found = [fault for test in tests if (fault := test(trace, phase, noise_std))]
    return found + peak_disagreement(trial, phase, noise_std)


def peak_disagreement(trial: Trial, phase: ImpactPhase, noise_std: float) -> list[str]:
    """The peak in trials.csv against that of the trace."""
    stated, trace = trial.peak_force, trial.trace
    if stated is None or trace is None:
        return []
    # where the force nearly vanishes, whether contact was lost is open: the peak of the whole trace may be meant
    peaks = np.array([phase.peak_force, trace.force[phase.start :].max()])
    if (np.abs(stated - peaks) <= 0.05 * peaks + 6.0 * noise_std).any():
        return []
    return [f"peak_force_n is {stated:g} N, but its trace peaks at {phase.peak_force:.4g} N (wrong label?)"]


def clipping(trace: Trace, phase: ImpactPhase, noise_std: float) -> str | None:
    """A flat top whose shoulders point well above it: the amplifier's range."""
    force = trace.force[phase.start : phase.stop]
    top = float(force.max())
    for first, last in _runs(force):
        inner = first >= 3 and last + 3 < force.size
        if last - first < 2 or force[first] != top or not inner:
            continue
        left = (force[first] - force[first - 3]) / 3.0
        right = (force[last] - force[last + 3]) / 3.0
        rise = (left + right) * (last - first + 1) / 8.0  # of a parabola with these slopes at its ends
        if rise > max(0.02 * top, 3.0 * noise_std, 3.0 * quantisation_step(force)):
            return f"its force is cut off at {top:.4g} N (amplifier?)"
    return None


def stuck(trace: Trace, phase: ImpactPhase, noise_std: float) -> str | None:
    """One value repeated although the force must have moved on, or although its noise would not allow it."""
    force = trace.force[phase.start : phase.stop]
    top = float(force.max())
    changes = np.abs(np.diff(force))
    moving = float(np.median(changes))
    for first, last in _runs(force):
        value, length = float(force[first]), last - first + 1
        if length < 5 or value < 0.05 * top:
            continue
        jump = abs(float(force[last + 1]) - value) if last + 1 < force.size else 0.0
        jumps = value < top and jump > max(0.04 * top, 8.0 * noise_std, 5.0 * moving)
        if jumps or _is_improbable(trace.force, length, noise_std):
            what = "is cut off" if value == top else "sticks"
            return f"its force {what} at {value:.4g} N for {length} samples (amplifier, cable?)"
    return None


def _is_improbable(force: Array, length: int, noise_std: float) -> bool:
    """Whether noise leaves no room for so many equal readings in a row.

    Two readings of noise far above the step q are equal with probability q/(2 sqrt(pi) std); a sensor that is
    read faster than it measures repeats itself more often, which the rest of the trace shows.
    """
    step = quantisation_step(force)
    if noise_std <= step or step == 0.0:
        return False
    repeated = max(int(np.count_nonzero(np.diff(force) == 0.0)) - (length - 1), 0) / force.size
    equal = max(step / (2.0 * np.pi**0.5 * noise_std), 1.5 * repeated)
    return bool(force.size * equal ** (length - 1) < 1e-5)


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


def spike(trace: Trace, phase: ImpactPhase, noise_std: float) -> str | None:
    """One to three samples far from their neighbours, in a trace that is smooth elsewhere.

    Only until contact is lost: a flange that touches again jumps to its pretension again.
    """
    force = trace.force
    if force.size < 12:
        return None
    neighbours = np.stack([force[4 - k : force.size - k] for k in (0, 1, 3, 4)])
    away = np.abs(force[2:-2] - np.median(neighbours, axis=0))
    inside = away[phase.start + 1 : max(phase.stop - 4, phase.start + 2)]
    usual = float(np.quantile(inside, 0.9))
    limit = max(0.06 * phase.peak_force, 12.0 * noise_std, 5.0 * usual)
    index = np.arange(2, force.size - 2)
    at_onset = (index >= phase.start - 3) & (index <= phase.start + 3)
    far = np.flatnonzero((away > limit) & ~at_onset & (index < phase.stop - 2))
    if far.size == 0:
        return None
    worst = int(index[far[np.argmax(away[far])]])
    return (
        f"its force has a spike of {force[worst]:.4g} N at {1e3 * float(trace.time[worst]):.3g} ms (cable?)"
    )


def _runs(values: Array) -> Iterator[tuple[int, int]]:
    """First and last index of each run of equal values of at least three samples."""
    edges = np.flatnonzero(np.diff(values) != 0.0)
    first = np.concatenate([[0], edges + 1])
    last = np.concatenate([edges, [values.size - 1]])
    for a, b in zip(first, last, strict=True):
        if b - a >= 2:
            yield int(a), int(b)

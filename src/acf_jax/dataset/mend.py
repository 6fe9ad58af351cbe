"""Damage of a recording that can be undone before anything is judged: what is left are measurements."""

from dataclasses import dataclass, replace

import numpy as np

from acf_jax.dataset.held import held_for, one_of_each
from acf_jax.dataset.lost import Lost, without_lost
from acf_jax.dataset.noise import look_at_approach, robust_std
from acf_jax.dataset.trials import GapDataset, Trace, Trial

ODD = 8.0  # standard deviations by which what one unloaded sensor reads lies off what it reads in the other trials
SMALL = 0.005  # of the largest force: a smaller offset is not worth a word
SAME = 1e-6  # relative: a stated peak that is the lost reading itself


@dataclass(frozen=True)
class Mended:
    """A data set whose damage is undone, and what that was, by trial."""

    dataset: GapDataset
    held: dict[str, float]  # samples for which each reading was held; one of each is left
    lost: dict[str, tuple[Lost, ...]]  # readings taken out
    zeros: dict[str, float]  # N, taken off where a trial alone was not zeroed


def mend(dataset: GapDataset) -> Mended:
    """Undo what can be: readings that are held, lost readings, and the zero of single trials."""
    held: dict[str, float] = {}
    trials = list(dataset.trials)
    for i, trial in enumerate(trials):
        if trial.trace and (times := held_for(trial.trace.force)) > 1.0:
            held[trial.name] = times
            trials[i] = replace(trial, trace=one_of_each(trial.trace, times))
    sifted = without_lost([t.trace for t in trials], list(dataset.conditions.values()))
    lost = {trial.name: found for trial, (_, found) in zip(trials, sifted, strict=True) if found}
    trials = [
        _with(trial, trace, lost.get(trial.name, ()))
        for trial, (trace, _) in zip(trials, sifted, strict=True)
    ]
    zeros = _odd_zeros(trials)
    trials = [_zeroed(trial, zeros.get(trial.name, 0.0)) for trial in trials]
    return Mended(replace(dataset, trials=tuple(trials)), held, lost, zeros)


def _with(trial: Trial, trace: Trace | None, lost: tuple[Lost, ...]) -> Trial:
    """The trial with this trace; a peak in its row that is a lost reading goes with it."""
    if not lost:
        return trial
    stated = trial.peak_force
    is_lost = stated is not None and any(np.isclose(stated, x.force, rtol=SAME, atol=0.0) for x in lost)
    return replace(trial, trace=trace, peak_force=None if is_lost else stated)


def _odd_zeros(trials: list[Trial]) -> dict[str, float]:
    """What the unloaded sensor reads in single trials beyond what it reads in most, N."""
    looks = {t.name: (look, t.trace) for t in trials if t.trace and (look := look_at_approach(t.trace))}
    if len(looks) < 3:
        return {}
    offsets = np.array([look.offset for look, _ in looks.values()])
    errors = np.array([look.noise_std / look.samples**0.5 for look, _ in looks.values()])
    heights = np.array([np.ptp(trace.force) for _, trace in looks.values()])
    away = offsets - np.median(offsets)
    # most agree: the trials' own scatter tells what is usual, whatever the odd ones read
    usual = np.maximum(robust_std(away), np.median(errors))
    odd = np.abs(away) > np.maximum(ODD * np.maximum(usual, errors), SMALL * heights)
    return {name: float(x) for name, x, is_odd in zip(looks, away, odd, strict=True) if is_odd}


def _zeroed(trial: Trial, zero: float) -> Trial:
    if not zero or trial.trace is None:
        return trial
    peak, top = trial.peak_force, float(trial.trace.force.max())
    if peak is not None and abs(peak - top) < abs(peak - (top - zero)):  # stated as it was read
        peak -= zero
    return replace(trial, trace=Trace(trial.trace.time, trial.trace.force - zero), peak_force=peak)

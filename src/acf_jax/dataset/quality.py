"""Data quality: what a look at the trials says before anything is fitted."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from acf_jax.dataset.advice import named, noise_warnings, repeat_warnings, trial_warnings
from acf_jax.dataset.consistency import compare
from acf_jax.dataset.look import TrialQuality, assess
from acf_jax.dataset.noise import (
    Noise,
    constant_approaches,
    difference_noise,
    fit_noise,
    look_at_approach,
)
from acf_jax.dataset.trials import GapDataset, Trace
from acf_jax.errors import InputError


@dataclass(frozen=True)
class Quality:
    """Quality of a data set: noise, each trial, which trials to leave out, and warnings in plain words."""

    noise: Noise
    trials: tuple[TrialQuality, ...]
    excluded: dict[str, str]  # trial: reason
    warnings: tuple[str, ...]

    @property
    def used(self) -> tuple[int, ...]:
        """Indices of the trials that are not excluded."""
        return tuple(i for i, trial in enumerate(self.trials) if trial.name not in self.excluded)


def assess_dataset(dataset: GapDataset) -> Quality:
    """Look at all trials: noise, phases, faulty trials, and what a user should know before the fit.

    Raises `InputError` when the noise is not stated and nothing tells it.
    """
    stated = dataset.measurement.force_noise_std_n
    typical = _typical_noise([t.trace for t in dataset.trials if t.trace]) if stated is None else stated
    alone = [assess(trial, dataset.rig.impact_time, typical) for trial in dataset.trials]
    alone = [_noisy(trial, alone) for trial in alone]
    healthy = [i for i, trial in enumerate(alone) if not trial.faults]
    spread = max(dataset.measurement.contact_velocity_rel_std, dataset.measurement.pretension_rel_std)
    agreements = compare(
        [dataset.trials[i] for i in healthy], [alone[i].phase for i in healthy], typical, spread
    )
    together = list(alone)
    onsets = _onset_offsets(alone)
    for i, agreement in zip(healthy, agreements, strict=True):
        faults = (agreement.fault,) if agreement.fault else ()
        offset = onsets[i] if agreement.trigger_offset is None else agreement.trigger_offset
        together[i] = replace(alone[i], trigger_offset=offset, faults=faults)
    excluded, shared = _exclude(together, dataset.conditions.values())
    sound = [
        (trial.trace, look)
        for trial, look in zip(dataset.trials, together, strict=True)
        if trial.trace and trial.name not in excluded
    ]
    traces = [trace for trace, _ in sound]
    approach = fit_noise(traces, stated)
    least = _error_of_steps(sound)
    noise = _choose_noise(dataset, approach, sound, least)
    constant = zip(sound, constant_approaches(traces), strict=True)
    still = [look.name for (_, look), is_still in constant if is_still and look.approach]
    of_noise = noise_warnings(dataset, noise, approach, still, least)
    of_repeats = repeat_warnings(dataset, together, excluded, noise)
    warnings = shared + of_noise + trial_warnings(together, excluded, noise) + of_repeats
    return Quality(noise, tuple(together), excluded, tuple(warnings))


def _typical_noise(traces: list[Trace]) -> float:
    """Median over trials of the noise in the approach, N, so that one bad trial does not count."""
    stds = [a.noise_std for a in map(look_at_approach, traces) if a]
    if stds:
        return float(np.median(stds))
    rough = difference_noise(traces)
    return rough.std if rough else 0.0


def _noisy(trial: TrialQuality, trials: list[TrialQuality]) -> TrialQuality:
    """`trial` with a fault when its approach is far noisier than that of the others."""
    stds = [t.approach.noise_std for t in trials if t.approach]
    if not trial.approach or not trial.phase or len(stds) < 3 or trial.approach.samples < 8:
        return trial
    usual = float(np.median(stds))
    std = trial.approach.noise_std
    if std <= max(6.0 * usual, 0.03 * trial.phase.peak_force):
        return trial
    reason = (
        f"its force before contact scatters by {std:.3g} N, in the other trials by {usual:.3g} N (cable?)"
    )
    return replace(trial, faults=(*trial.faults, reason))


def _onset_offsets(trials: list[TrialQuality]) -> list[float | None]:
    """By how much each trial's first clear sample comes late, s; None unless contact starts alike in most."""
    onsets = np.array([t.phase.onset if t.phase else np.nan for t in trials])
    if np.isfinite(onsets).sum() < 3:
        return [None] * len(trials)
    late = onsets - np.nanmedian(onsets)
    steps = np.array([1.0 / t.sample_rate if t.sample_rate else np.nan for t in trials])
    if np.mean(np.abs(late[np.isfinite(late)]) < 0.5 * steps[np.isfinite(late)]) < 0.8:
        return [None] * len(trials)
    return [float(x) if np.isfinite(x) else None for x in late]


def _exclude(
    trials: list[TrialQuality], conditions: Iterable[Sequence[int]]
) -> tuple[dict[str, str], list[str]]:
    """The faulty trials with their reasons; what many share, or all of one condition, is the rig, and a warning."""
    faulty = {trial.name: "; ".join(trial.faults) for trial in trials if trial.faults}
    if len(faulty) > max(1, len(trials) // 4) or len(trials) - len(faulty) < 3:
        examples = "; ".join(f"{name}: {reason}" for name, reason in list(faulty.items())[:3])
        return {}, [
            f"{len(faulty)} of {len(trials)} trials look faulty, too many to leave out: all are kept"
            f" (for example {examples}); check sensor, cable and labels"
        ]
    warnings = []
    for group in conditions:
        names = [trials[i].name for i in group]
        if len(group) > 1 and all(name in faulty for name in names):
            reasons = [faulty.pop(name) for name in names]
            warnings.append(
                f"all trials of one condition look faulty and are kept, as they agree ({named(names)}: {reasons[0]})"
            )
    return faulty, warnings


def _choose_noise(
    dataset: GapDataset, approach: Noise | None, sound: list[tuple[Trace, TrialQuality]], least: float
) -> Noise:
    """The stated size with the estimated colour; without either, what differences and the peaks allow.

    No estimate is below `least`, by which readings in steps err; a stated size is kept.
    """
    usable = approach if approach and approach.std > 0.0 else None
    differences = None if usable else _differences(approach, sound)
    told = approach or differences
    stated = dataset.measurement.force_noise_std_n
    if stated is not None:
        if told is None:
            return Noise(stated, source="stated")
        return replace(told, std=stated, source="stated")
    for found in (usable, differences, _repeats(dataset), _assumed(dataset)):
        if found and (std := max(found.std, least)) > 0.0:
            offset, offset_std = (told.offset, told.offset_std) if told else (0.0, 0.0)
            return replace(found, std=std, offset=offset, offset_std=offset_std)
    raise InputError(
        f"{dataset.folder / 'dataset.yaml'}: measurement.force_noise_std_n: is missing, and neither traces nor"
        " peaks tell the noise of the force; state it"
    )


def _error_of_steps(sound: list[tuple[Trace, TrialQuality]]) -> float:
    """Standard deviation, N, by which readings in steps err once the force moves."""
    return float(np.median([look.quantisation for _, look in sound])) / 12.0**0.5 if sound else 0.0


def _differences(approach: Noise | None, sound: list[tuple[Trace, TrialQuality]]) -> Noise | None:
    """Noise from differences; what was constant before contact may be so after it, and is cut off there."""
    if approach is None:
        return difference_noise([trace for trace, _ in sound])
    ends = [(trace, look.phase.stop) for trace, look in sound if look.phase]
    return difference_noise([Trace(trace.time[:stop], trace.force[:stop]) for trace, stop in ends])


def _repeats(dataset: GapDataset) -> Noise | None:
    """Noise from the scatter of peaks that repeat a condition; None where there are too few."""
    groups = [[dataset.trials[i].peak_force for i in group] for group in dataset.conditions.values()]
    known = [[peak for peak in group if peak is not None] for group in groups]
    spreads = [(len(group) - 1, float(np.var(group, ddof=1))) for group in known if len(group) > 1]
    count = sum(n for n, _ in spreads)
    if count < 3:
        return None
    std = (sum(n * v for n, v in spreads) / count) ** 0.5
    return Noise(std, samples=count + len(spreads), source="repeats")


def _assumed(dataset: GapDataset) -> Noise:
    """Half a percent of the largest peak."""
    peaks = [abs(t.peak_force) for t in dataset.trials if t.peak_force is not None]
    return Noise(0.005 * max(peaks, default=100.0), source="assumed")

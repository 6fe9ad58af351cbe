"""Data quality: what a look at the trials says before anything is fitted."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from acf_jax.dataset.consistency import compare
from acf_jax.dataset.faults import trace_faults
from acf_jax.dataset.noise import (
    Approach,
    Noise,
    approach_samples,
    constant_approaches,
    difference_noise,
    fit_noise,
    look_at_approach,
    quantisation_step,
)
from acf_jax.dataset.phase import NEGATIVE, ImpactPhase, find_impact
from acf_jax.dataset.trials import GapDataset, Trace, Trial
from acf_jax.errors import InputError


@dataclass(frozen=True)
class TrialQuality:
    """What one trial shows by itself and against the others."""

    name: str
    approach: Approach | None  # None: no trace, or too few samples before contact
    phase: ImpactPhase | None  # None: no trace, or no impact seen in it
    sample_rate: float | None  # Hz
    quantisation: float  # N, step of the force readings; 0: none seen
    trigger_offset: float | None  # s, against the other trials; > 0: the impact comes late
    faults: tuple[str, ...]  # why the trial is not to be trusted; empty for a healthy one


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


def assess(trial: Trial, impact_time: float, noise_std: float | None = None) -> TrialQuality:
    """Look at one trial by itself.

    Args:
        trial: the trial.
        impact_time: how long an impact lasts, roughly, s.
        noise_std: noise of one sample, N; None: taken from the approach.
    """
    trace = trial.trace
    if trace is None:
        return TrialQuality(trial.name, None, None, None, 0.0, None, ())
    approach = look_at_approach(trace)
    own = approach.noise_std if approach else 0.0
    std = own if noise_std is None else noise_std
    offset = approach.offset if approach else 0.0
    phase = find_impact(trace, std, impact_time, offset)
    rate = 1.0 / float(np.median(np.diff(trace.time)))
    faults = trace_faults(trial, phase, std, offset)
    return TrialQuality(
        trial.name, approach, phase, rate, quantisation_step(trace.force), None, tuple(faults)
    )


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
    of_noise = _noise_warnings(dataset, noise, approach, still, least)
    warnings = shared + of_noise + _trial_warnings(together, excluded, noise)
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
                f"all trials of one condition look faulty and are kept, as they agree ({_list(names)}: {reasons[0]})"
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
            return replace(found, std=std, offset=told.offset if told else 0.0)
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


def _noise_warnings(
    dataset: GapDataset, noise: Noise, approach: Noise | None, still: list[str], least: float
) -> list[str]:
    warnings = []
    traced = [trial.trace for trial in dataset.trials if trial.trace]
    stated = dataset.measurement.force_noise_std_n
    told = approach if approach and approach.std > 0.0 else None
    if stated is not None and told is not None:
        ratio = told.std / stated
        if not 1.0 / 1.4 < ratio < 1.4:
            warnings.append(
                f"force_noise_std_n is stated as {stated:g} N, but the samples before contact scatter by"
                f" {told.std:.3g} N; correct it, or leave it out to have it estimated"
            )
    if stated is not None and stated < least:
        warnings.append(
            f"force_noise_std_n is stated as {stated:g} N, but readings in steps of {least * 12.0**0.5:.3g} N err by"
            f" {least:.3g} N alone; state at least that"
        )
    if still:
        what = f"the force does not change before contact in {_list(still)} (dead band, padding, coarse readings?)"
        if told is not None:
            outcome = "the noise is taken from the other trials"
        elif stated is not None:
            outcome = "the noise is taken as stated, and as white"
        else:
            outcome = f"the noise is taken as {noise.std:.3g} N, and as white; state force_noise_std_n"
        warnings.append(f"{what}; {outcome}")
    if traced and not any(approach_samples(trace).time.size >= 5 for trace in traced):
        warnings.append(
            "no trace has samples before contact; noise and sensor offset cannot be checked:"
            " record at least 20 samples before contact"
        )
    if noise.source == "assumed":
        warnings.append(
            f"the noise of the force is unknown and assumed as {noise.std:.3g} N; state force_noise_std_n"
        )
    if not noise.is_white:
        longest = max(float(-trace.time[0]) for trace in traced)
        what = (
            f"the noise is coloured: {100 * noise.share:.0f} % of its variance lasts about"
            f" {1e3 * noise.correlation_time:.2g} ms, so samples are not independent"
            if noise.correlation_time < longest
            else f"the sensor offset changes from trial to trial by {noise.share**0.5 * noise.std:.2g} N"
        )
        warnings.append(f"{what}; taken into account")
    return warnings


def _trial_warnings(trials: list[TrialQuality], excluded: dict[str, str], noise: Noise) -> list[str]:
    warnings = [f"trial {name} is left out: {reason}" for name, reason in excluded.items()]
    kept = [trial for trial in trials if trial.name not in excluded]
    offsets = [trial.approach.offset for trial in kept if trial.approach]
    if offsets and noise.samples:
        alike = max(1.0, noise.samples_per_independent(1.0 / (kept[0].sample_rate or 1.0)))
        if abs(noise.offset) > 4.0 * noise.std * (alike / noise.samples) ** 0.5 + 0.1 * noise.std:
            warnings.append(
                f"the sensor reads {noise.offset:+.3g} N before contact; zero it before each trial"
            )
    drifting = [
        t.name for t in kept if t.approach and noise.is_white and _drifts(t.approach, t.phase, noise.std)
    ]
    if drifting:
        warnings.append(f"the sensor drifts before contact in {_list(drifting)}; let it warm up")
    missed = [
        (t.phase.missed_peak / t.phase.peak_force, t) for t in kept if t.phase and t.phase.peak_force > 0
    ]
    share, worst = max(missed, key=lambda pair: pair[0], default=(0.0, None))
    if worst is not None and share > 0.02:
        warnings.append(
            f"at {worst.sample_rate:.0f} Hz the sampled peak may be up to {100 * share:.0f} % too low"
            f" (trial {worst.name}); the force changes from sample to sample: judge by traces, sample faster"
        )
    late = [
        t.name
        for t in kept
        if t.trigger_offset and t.sample_rate and abs(t.trigger_offset) * t.sample_rate > 0.75
    ]
    if late:
        warnings.append(f"the trigger is off by a sample or more in {_list(late)}")
    below = [t.name for t in kept if _reads_below_zero(t.approach, t.phase)]
    if below:
        warnings.append(
            f"the force reads below zero before contact is lost in {_list(below)}: nothing pulls there, so the sensor"
            " rings or leaks charge"
        )
    ended = Counter(t.phase.contact_lost is not None for t in kept if t.phase)
    if ended[True]:
        warnings.append(
            f"contact is lost within the trace in {ended[True]} of {sum(ended.values())} trials;"
            " what follows is not used"
        )
    again = [t.name for t in kept if t.phase and t.phase.second_contact is not None]
    if again:
        warnings.append(f"the flange rebounds and touches a second time in {_list(again)}")
    return warnings


def _drifts(approach: Approach, phase: ImpactPhase | None, noise_std: float) -> bool:
    if phase is None or approach.drift_std == 0.0:
        return False
    by_the_peak = abs(approach.drift) * phase.peak_time
    return abs(approach.drift) > 5.0 * approach.drift_std and by_the_peak > noise_std


def _reads_below_zero(approach: Approach | None, phase: ImpactPhase | None) -> bool:
    if phase is None:
        return False
    peak = phase.peak_force - (approach.offset if approach else 0.0)
    return phase.lowest_force < -NEGATIVE * peak


def _list(names: list[str]) -> str:
    shown = ", ".join(names[:6])
    return shown if len(names) <= 6 else f"{shown} and {len(names) - 6} more"

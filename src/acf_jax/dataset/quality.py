"""Data quality: what a look at the trials says before anything is fitted."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from acf_jax.dataset.advice import damage, mended_lines, noise_warnings, stated_noise, trial_warnings
from acf_jax.dataset.faulty import compared, exclude, suspects
from acf_jax.dataset.look import TrialQuality, assess, at_one_ceiling
from acf_jax.dataset.low_pass import noise_behind, statement
from acf_jax.dataset.mend import mend
from acf_jax.dataset.noise import (
    Noise,
    constant_approaches,
    difference_noise,
    fit_noise,
    look_at_approach,
)
from acf_jax.dataset.trials import GapDataset, Trace
from acf_jax.dataset.trust import Limit, Trust, about, design_limits, left_out, offset_limit, rate_limit
from acf_jax.errors import InputError

NOISY = 4.0  # times the usual noise, beyond which a trial does not count in what is pooled


@dataclass(frozen=True)
class Quality:
    """Quality of a data set: noise, each trial, which trials to leave out, and warnings in plain words."""

    dataset: GapDataset  # as it is compared, what can be mended is mended
    noise: Noise
    trials: tuple[TrialQuality, ...]
    excluded: dict[str, str]  # trial: reason
    damaged: tuple[str, ...]  # trials that are compared although something is wrong with them
    doubts: tuple[str, ...]  # those of the warnings, but for trials left out, that make the rest less sure
    warnings: tuple[str, ...]
    limits: tuple[Limit, ...]  # of what the data can tell, but for trials left out

    @property
    def used(self) -> tuple[int, ...]:
        """Indices of the trials that are not excluded."""
        return self._without(self.excluded)

    def trust(self, excluded: Mapping[str, str] | None = None) -> Trust:
        """Whether the data can be trusted; `excluded`: trials left out in the end, with the reason."""
        out = self.excluded if excluded is None else excluded
        used = self._without(out)
        design = design_limits(self.dataset, used)
        return Trust(
            about(self.dataset, used, self.trials), (*left_out(out, len(self.trials)), *self.limits, *design)
        )

    def _without(self, excluded: Mapping[str, str]) -> tuple[int, ...]:
        return tuple(i for i, trial in enumerate(self.trials) if trial.name not in excluded)


def assess_dataset(dataset: GapDataset) -> Quality:
    """Look at all trials: noise, phases, faulty trials, and what a user should know before the fit.

    Raises `InputError` when the noise is not stated and nothing tells it.
    """
    mended = mend(dataset)
    dataset = mended.dataset
    stated = dataset.measurement.force_noise_std_n
    typical = _typical_noise([t.trace for t in dataset.trials if t.trace]) if stated is None else stated
    end = dataset.measurement.range_n or np.inf
    looks = [
        assess(trial, dataset.rig.impact_time, typical, end - mended.zeros.get(trial.name, 0.0))
        for trial in dataset.trials
    ]
    looks = at_one_ceiling(dataset, looks)
    suspected = suspects(mended, looks, typical)
    looks, differing, shared = compared(dataset, looks, suspected, typical)
    excluded, kept = exclude(looks, suspected | differing)
    sound = _usual(
        [
            (trial.trace, look)
            for trial, look in zip(dataset.trials, looks, strict=True)
            if trial.trace and trial.name not in excluded
        ]
    )
    traces = [trace for trace, _ in sound]
    low_pass = dataset.measurement.low_pass
    approach = noise_behind(traces, low_pass) if low_pass else fit_noise(traces, stated)
    least = _error_of_steps(sound)
    noise = _choose_noise(dataset, approach, sound, least, looks)
    constant = zip(sound, constant_approaches(traces), strict=True)
    still = [look.name for (_, look), is_still in constant if is_still and look.approach]
    damaged = damage(dataset, looks, excluded, kept, shared, noise)
    undone, misstated = mended_lines(mended), stated_noise(stated, approach, least)
    sound_looks = [look for look in looks if look.name not in excluded]
    measured = list(filter(None, [rate_limit(sound_looks), offset_limit(sound_looks, noise)]))
    doubts = (
        *(Limit("readings undone", line) for line in undone),
        *(Limit(d.word, d.line) for d in damaged),
        *(Limit("stated noise", line) for line in misstated),
    )
    found = Quality(
        dataset=dataset,
        noise=noise,
        trials=tuple(looks),
        excluded=excluded,
        damaged=tuple(dict.fromkeys(name for d in damaged for name in d.trials)),
        doubts=tuple(limit.line for limit in doubts),
        warnings=(),
        limits=(*doubts, *measured),
    )
    return replace(
        found,
        warnings=(
            *found.doubts,
            *([statement(low_pass)] if low_pass else []),
            *noise_warnings(dataset, noise, approach, still),
            *(f"trial {name} is left out: {reason}" for name, reason in excluded.items()),
            *(limit.line for limit in (*measured, *design_limits(dataset, found.used))),
            *trial_warnings(looks, excluded, noise),
        ),
    )


def _usual(sound: list[tuple[Trace, TrialQuality]]) -> list[tuple[Trace, TrialQuality]]:
    """The trials without those far noisier than most: what is pooled is not to rest on a few."""
    stds = [look.approach.noise_std for _, look in sound if look.approach]
    most = NOISY * float(np.median(stds)) if stds else 0.0
    return [
        (trace, look)
        for trace, look in sound
        if not look.approach or look.approach.noise_std <= most or not most
    ]


def _typical_noise(traces: list[Trace]) -> float:
    """Median over trials of the noise in the approach, N, so that one bad trial does not count."""
    stds = [a.noise_std for a in map(look_at_approach, traces) if a]
    if stds:
        return float(np.median(stds))
    rough = difference_noise(traces)
    return rough.std if rough else 0.0


def _choose_noise(
    dataset: GapDataset,
    approach: Noise | None,
    sound: list[tuple[Trace, TrialQuality]],
    least: float,
    looks: list[TrialQuality],
) -> Noise:
    """The stated size with the estimated colour; without either, what differences and the peaks allow.

    No estimate is below `least`, by which readings in steps err; a stated size is kept.
    """
    usable = approach if approach and approach.std > 0.0 else None
    is_rough = dataset.measurement.low_pass is None  # a filter leaves nothing of noise in differences
    differences = _differences(approach, sound) if is_rough and not usable else None
    told = approach or differences
    stated = dataset.measurement.force_noise_std_n
    if stated is not None:
        if told is None:
            return Noise(stated, source="stated")
        return replace(told, std=stated, source="stated")
    for found in (usable, differences, _repeats(dataset, looks), _assumed(dataset)):
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


def _repeats(dataset: GapDataset, looks: list[TrialQuality]) -> Noise | None:
    """Noise from the scatter of peaks that repeat a condition; None where there are too few."""
    groups = [
        [dataset.trials[i].peak_force for i in group if not looks[i].peak_is_bound]
        for group in dataset.conditions.values()
    ]
    known = [np.array([peak for peak in group if peak is not None]) for group in groups]
    away = [(g - g.mean()) * (g.size / (g.size - 1)) ** 0.5 for g in known if g.size > 1]
    count = sum(g.size - 1 for g in away)
    if count < 3:
        return None
    std = float(np.quantile(np.abs(np.concatenate(away)), 0.683))  # whatever a wrong label is off by
    return Noise(std, samples=count + len(away), source="repeats")


def _assumed(dataset: GapDataset) -> Noise:
    """Half a percent of the largest peak."""
    peaks = [abs(t.peak_force) for t in dataset.trials if t.peak_force is not None]
    return Noise(0.005 * max(peaks, default=100.0), source="assumed")

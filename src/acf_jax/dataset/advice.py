"""What a user should know of the data before the fit, in plain words."""

from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

from acf_jax.dataset.look import CUT_OFF, TrialQuality
from acf_jax.dataset.mend import Mended
from acf_jax.dataset.noise import Approach, Noise, approach_samples
from acf_jax.dataset.phase import NEGATIVE, ImpactPhase
from acf_jax.dataset.trials import GapDataset
from acf_jax.dataset.trust import SATURATION

BOUNDS = "These readings count as 'at least this much', and the peaks of these trials are unknown"
FARTHEST = 8.0  # standard deviations that peaks of one condition may lie apart
DAMAGE = "damaged trials"


class Damage(NamedTuple):
    """What is wrong with some trials."""

    word: str  # in a headline
    line: str
    trials: list[str]


def stated_noise(stated: float | None, approach: Noise | None, least: float) -> list[str]:
    """What speaks against the noise as stated, N; `least`: what readings in steps err by alone, N."""
    warnings = []
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
    return warnings


def noise_warnings(dataset: GapDataset, noise: Noise, approach: Noise | None, still: list[str]) -> list[str]:
    """Of the noise: what tells it, and what had to be assumed; `still`: trials whose approach does not change."""
    warnings = []
    traced = [trial.trace for trial in dataset.trials if trial.trace]
    stated = dataset.measurement.force_noise_std_n
    told = approach if approach and approach.std > 0.0 else None
    if still:
        what = f"the force does not change before contact in {named(still)} (dead band, padding, coarse readings?)"
        if told is not None:
            outcome = "the noise is taken from the other trials"
        elif stated is not None:
            outcome = "the noise is taken as stated, and as white"
        else:
            outcome = f"the noise is taken as {noise.std:.3g} N, and as white; state force_noise_std_n"
        warnings.append(f"{what}; {outcome}")
    if traced and not any(approach_samples(trace).time.size >= 5 for trace in traced):
        warnings.append(
            "the traces have too few samples before contact to check noise and sensor offset:"
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


def trial_warnings(trials: list[TrialQuality], excluded: dict[str, str], noise: Noise) -> list[str]:
    """Of the trials that are not left out: what the sensor, the trigger and the impacts show."""
    warnings = []
    kept = [trial for trial in trials if trial.name not in excluded]
    if at_range := [trial.name for trial in kept if trial.at_range]:
        warnings.append(
            f"the end of the sensor's range is reached in {len(at_range)} of {len(trials)} trials"
            f" ({named(at_range)}). {BOUNDS}"
        )
    drifting = [
        t.name for t in kept if t.approach and noise.is_white and _drifts(t.approach, t.phase, noise.std)
    ]
    if drifting:
        warnings.append(f"the sensor drifts before contact in {named(drifting)}; let it warm up")
    late = [
        t.name
        for t in kept
        if t.trigger_offset and t.sample_rate and abs(t.trigger_offset) * t.sample_rate > 0.75
    ]
    if late:
        warnings.append(f"the trigger is off by a sample or more in {named(late)}")
    below = [t.name for t in kept if t.phase and t.phase.lowest_force < -NEGATIVE * t.phase.height]
    if below:
        warnings.append(
            f"the force reads below zero before contact is lost in {named(below)}: nothing pulls there, so the sensor"
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
        warnings.append(f"the flange rebounds and touches a second time in {named(again)}")
    return warnings


def damage(
    dataset: GapDataset,
    trials: list[TrialQuality],
    excluded: dict[str, str],
    suspected: dict[str, str],
    shared: dict[str, str],
    noise: Noise,
) -> list[Damage]:
    """What is wrong with trials that are compared all the same.

    **Arguments:** `suspected`: trials that look faulty but are kept, with the reason; `shared`: those of which most
    repeats have the same trace.
    """
    found = []
    ends = dict(_cut_off(dataset, trials))
    cut = {t.name: ends[t.name] for t in trials if t.name in ends.keys() - excluded.keys() and not t.at_range}
    if cut:
        low, high = min(cut.values()), max(cut.values())
        at = f"{low:.4g} N" if low == high else f"{low:.4g} to {high:.4g} N"
        line = (
            f"the force is cut off at {at} in {len(cut)} of {len(trials)} trials ({named(list(cut))}): where the"
            f" sensor's range ends, state it as range_n. {BOUNDS}: use a sensor of a larger range, or touch more"
            " slowly"
        )
        found.append(Damage(SATURATION, line, list(cut)))
    # that a force is cut off has been said
    suspected = {
        name: why
        for name, why in suspected.items()
        if not (name in cut and why.startswith(CUT_OFF) and ";" not in why)
    }
    if suspected:
        examples = "; ".join(f"{name}: {reason}" for name, reason in list(suspected.items())[:3])
        line = (
            f"{len(suspected)} of {len(trials)} trials look faulty, too many to leave out: all are kept"
            f" (for example {examples}); check sensor, cable and labels"
        )
        found.append(Damage(DAMAGE, line, list(suspected)))
    if shared:
        names = list(shared)
        line = (
            f"{named(names)} agree with the repeats of their condition, but not with other conditions ({names[0]}:"
            f" {shared[names[0]]}): they may have gone beyond a limit, or their labels are wrong; kept"
        )
        found.append(Damage(DAMAGE, line, names))
    return [*found, *_far_repeats(dataset, trials, excluded, noise)]


def _cut_off(dataset: GapDataset, trials: list[TrialQuality]) -> Iterator[tuple[str, float]]:
    """The trials whose force is cut off, and the reading, N, where it is."""
    for trial, look in zip(dataset.trials, trials, strict=True):
        if look.phase and look.phase.cut_off is not None:
            yield look.name, look.phase.peak_force
        elif look.peak_is_bound and trial.peak_force is not None:
            yield look.name, trial.peak_force


def _far_repeats(
    dataset: GapDataset, trials: list[TrialQuality], excluded: dict[str, str], noise: Noise
) -> list[Damage]:
    """Of trials of one condition whose peaks lie farther apart than their scatter and the noise let them."""
    scatter = dataset.measurement.contact_velocity_rel_std + dataset.measurement.pretension_rel_std
    lines: list[str] = []
    names: list[str] = []
    cut = dict(_cut_off(dataset, trials))
    for (velocity, pretension), group in dataset.conditions.items():
        looks = [(trials[i].name, dataset.trials[i].peak_force, trials[i].phase) for i in group]
        peaks = {
            name: phase.height if phase else peak
            for name, peak, phase in looks
            if name not in excluded and name not in cut
        }
        known = {name: peak for name, peak in peaks.items() if peak is not None}
        low, high = min(known.values(), default=0.0), max(known.values(), default=0.0)
        if high - low > FARTHEST * (scatter * high + noise.std):
            lines.append(f"{velocity:g} m/s and {pretension:g} N peak between {low:.4g} and {high:.4g} N")
            names += known
    if not lines:
        return []
    more = f" (so at {len(lines) - 1} other conditions)" if len(lines) > 1 else ""
    line = (
        f"repeats at {lines[0]}{more}, farther apart than scatter and noise let them: check velocity and pretension of"
        " each in trials.csv; else a limit is only just reached there, or the rig does not repeat"
    )
    return [Damage("repeats far apart", line, names)]


def mended_lines(mended: Mended) -> list[str]:
    """What was wrong with the recording and is undone, a line for each kind."""
    n, lines = len(mended.dataset.trials), []
    if mended.held:
        low, high = min(mended.held.values()), max(mended.held.values())
        times = f"{low:.3g}" if high - low < 0.1 else f"{low:.3g} to {high:.3g}"
        lines.append(
            f"each reading is held for {times} samples in {_of_all(list(mended.held), n)}: the sensor is slower than"
            " its recorder; one of each is used"
        )
    if mended.lost:
        shown = [
            f"{name}: {x.force:.4g} N at {1e3 * x.time:.3g} ms"
            for name, lost in mended.lost.items()
            for x in lost
        ]
        more = f"; and {len(shown) - 3} more" if len(shown) > 3 else ""
        lines.append(
            f"{len(shown)} lost reading{'s are' if len(shown) > 1 else ' is'} taken out of {len(mended.lost)} of {n}"
            f" trials ({'; '.join(shown[:3])}{more})"
        )
    if mended.zeros:
        shown = [f"{name} {zero:+.3g} N" for name, zero in mended.zeros.items()]
        lines.append(
            f"the unloaded sensor reads something else than in the other trials: {named(shown)}; taken off, zero it"
            " before each trial"
        )
    return lines


def _of_all(names: list[str], n: int) -> str:
    return f"all {n} trials" if len(names) == n else f"{len(names)} of {n} trials ({named(names)})"


def _drifts(approach: Approach, phase: ImpactPhase | None, noise_std: float) -> bool:
    if phase is None or approach.drift_std == 0.0:
        return False
    by_the_peak = abs(approach.drift) * phase.peak_time
    return abs(approach.drift) > 5.0 * approach.drift_std and by_the_peak > noise_std


def named(names: list[str]) -> str:
    """The first of some names, and how many more there are."""
    shown = ", ".join(names[:6])
    return shown if len(names) <= 6 else f"{shown} and {len(names) - 6} more"

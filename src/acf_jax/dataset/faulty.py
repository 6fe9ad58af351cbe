"""Which trials are not to be trusted, by themselves and against the others, and which of them are left out."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from acf_jax.dataset.consistency import compare, show_the_same
from acf_jax.dataset.faults import peak_disagreement
from acf_jax.dataset.look import TrialQuality
from acf_jax.dataset.lost import MOST, Lost
from acf_jax.dataset.mend import Mended
from acf_jax.dataset.trials import GapDataset, Trial


def suspects(mended: Mended, trials: list[TrialQuality], noise_std: float) -> dict[str, list[str]]:
    """What speaks against trials by themselves, by name: what their repeats show as well is the rig."""
    stds = [t.approach.noise_std for t in trials if t.approach]
    usual = float(np.median(stds)) if len(stds) >= 3 else 0.0
    dataset = mended.dataset
    found: dict[str, list[str]] = {}
    for i, (trial, look) in enumerate(zip(dataset.trials, trials, strict=True)):
        if look.tells_nothing or not look.phase:
            continue
        odd = look.oddities
        if odd and _repeats_show_it(i, dataset, trials, noise_std):
            odd = ()
        reasons = [
            *_noisy(look, usual),
            *_lossy(trial, mended.lost.get(trial.name, ())),
            *look.faults,
            *odd,
            *peak_disagreement(trial, look.phase, noise_std),
        ]
        if reasons:
            found[look.name] = reasons
    return found


def compared(
    dataset: GapDataset,
    trials: list[TrialQuality],
    suspects: dict[str, list[str]],
    noise_std: float,
) -> tuple[list[TrialQuality], dict[str, list[str]], dict[str, str]]:
    """The trials with their trigger offsets, those that differ from the others, and those whose repeats do so, too."""
    healthy = [
        i for i, t in enumerate(trials) if not (t.tells_nothing or t.peak_is_bound) and t.name not in suspects
    ]
    agreements = compare(
        [dataset.trials[i] for i in healthy], [trials[i].phase for i in healthy], noise_std, _spread(dataset)
    )
    onsets = _onset_offsets(trials)
    together = list(trials)
    alone: dict[str, list[str]] = {}
    shared: dict[str, str] = {}
    for i, agreement in zip(healthy, agreements, strict=True):
        offset = onsets[i] if agreement.trigger_offset is None else agreement.trigger_offset
        together[i] = replace(trials[i], trigger_offset=offset)
        if agreement.fault is None:
            continue
        if agreement.is_label or not _repeats_show_it(i, dataset, trials, noise_std):
            alone[trials[i].name] = [agreement.fault]
        else:
            shared[trials[i].name] = agreement.fault
    return together, alone, shared


def exclude(
    trials: list[TrialQuality], suspects: dict[str, list[str]]
) -> tuple[dict[str, str], dict[str, str]]:
    """The trials to leave out, and those suspected but kept, with their reasons: what many share may be the rig."""
    void = {t.name: "; ".join(t.faults) for t in trials if t.tells_nothing}
    suspected = {t.name: "; ".join(suspects[t.name]) for t in trials if t.name in suspects}
    if len(suspected) > max(1, len(trials) // 4) or len(trials) - len(void) - len(suspected) < 3:
        return void, suspected
    return {t.name: reason for t in trials if (reason := (void | suspected).get(t.name))}, {}


def _noisy(trial: TrialQuality, usual: float) -> list[str]:
    """Why the approach of a trial is not to be trusted, against the noise that is usual."""
    if not trial.approach or not trial.phase or not usual or trial.approach.samples < 8:
        return []
    std = trial.approach.noise_std
    if std <= max(6.0 * usual, 0.03 * trial.phase.height):
        return []
    return [
        f"its force before contact scatters by {std:.3g} N, in the other trials by {usual:.3g} N (cable?)"
    ]


def _lossy(trial: Trial, lost: Sequence[Lost]) -> list[str]:
    """Why a trial that lost many readings is not to be trusted: then the others may be wrong, too."""
    count = len(lost)
    of = count + (trial.trace.time.size if trial.trace else 0)
    return [f"{count} or more of its {of} readings are lost (cable?)"] if count > MOST * of else []


def _repeats_show_it(i: int, dataset: GapDataset, trials: list[TrialQuality], noise_std: float) -> bool:
    """Whether most repeats of trial `i` have the same trace."""
    own, numbers = trials[i].phase, dataset.condition_of
    repeats = [
        j for j, number in enumerate(numbers) if number == numbers[i] and j != i and dataset.trials[j].trace
    ]
    if own is None or not repeats:
        return False
    same = [
        show_the_same(dataset.trials[i], dataset.trials[j], (own, there), noise_std, _spread(dataset))
        for j in repeats
        if (there := trials[j].phase) is not None and not trials[j].tells_nothing
    ]
    return 2 * sum(same) >= len(repeats)


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


def _spread(dataset: GapDataset) -> float:
    """Relative standard deviation of velocity or pretension, trial to trial."""
    return max(dataset.measurement.contact_velocity_rel_std, dataset.measurement.pretension_rel_std)

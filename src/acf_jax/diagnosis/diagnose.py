"""The whole diagnosis: quality, fits, probabilities, held-out figures, what cannot be told apart, what to do next."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from acf_jax.dataset import GapDataset, Quality, assess_dataset
from acf_jax.diagnosis import candidates, separate
from acf_jax.diagnosis.experiment import Experiment, propose
from acf_jax.diagnosis.fit import Fit, fit
from acf_jax.diagnosis.observe import Observations, observe
from acf_jax.diagnosis.peaks import same_peaks
from acf_jax.diagnosis.score import (
    UNKNOWN,
    Scored,
    components,
    credible_set,
    doubt,
    evidence_of,
    explanations,
    is_port,
    probabilities,
)
from acf_jax.diagnosis.space import Explanation, parameters
from acf_jax.diagnosis.validate import (
    EXTRAPOLATION,
    FREE_EXTRAPOLATION,
    GapFigures,
    HeldOut,
    Shrinkage,
    figures,
    force_shrinkage,
    hold_out,
    peak_shrinkage,
)
from acf_jax.diagnosis.where import GapMap, gap_map
from acf_jax.effects import library

LEADERS = 3  # single effects from which the forward search goes on
UNEXPLAINED = 1.5  # chi-square of a sample above which twice as many effects lead
PARTNERS = 3  # effects that are tried beside each of them
WORTH_A_SECOND = 9.0  # chi-square that a partner has to promise before the pair is fitted
OUTLIER = 5.0  # a trial is left out where its misfit is this many times that of the others, and beyond chance
DETECTABLE = 3.0  # whitened distance at which an effect of its typical size counts as detectable
HOPEFUL = 0.7  # where the interval of the shrinkage reaches it, the explanation is not doubted
TOO_MANY = 6  # explanations in the credible set: these trials have not answered

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Diagnosis:
    """Everything a diagnosis found; `report` and the command line write it out."""

    dataset: GapDataset
    quality: Quality
    observations: Observations
    verdict: str
    scored: tuple[Scored, ...]
    credible: tuple[Explanation, ...]
    component: dict[str, float]
    indistinguishable: tuple[separate.Pair, ...]
    absorbed: dict[str, float]
    detectability: tuple[separate.Detectability, ...]
    gap_map: GapMap
    gap: dict[str, GapFigures]
    noise_floor_rms_n: float | None
    shrinkage_force: Shrinkage | None
    shrinkage_peak: Shrinkage | None
    fits: tuple[Fit, ...]  # the paper's model first, the others most probable first
    probability: tuple[float, ...]  # of each fit
    nominal: Fit
    corrected: Fit
    held: dict[str, HeldOut]
    next_experiment: Experiment | None
    excluded: dict[str, str]
    warnings: tuple[str, ...] = field(default=())


def diagnose(
    dataset: GapDataset,
    seed: int = 0,
    progress: Progress = lambda stage: None,
    without: Collection[str] = (),
) -> Diagnosis:
    """Where the gap between the paper's model and measured impacts lies, why, and how far it shrinks.

    **Arguments:** `dataset`: as `read_dataset` gives it, or built from arrays. `seed`: of the bootstrap; the same seed
    gives the same answer. `progress`: called with the name of each stage as it begins. `without`:
    effects of the library that cannot be the cause, as one who knows the rig would say.

    **Returns:** a `Diagnosis`. Needs float64 (`jax_enable_x64`).

    **Raises:** `InputError` when fewer than three trials can be used.
    """
    progress("looking at the data")
    quality = assess_dataset(dataset)
    observations = observe(dataset, quality)
    excluded = dict(quality.excluded)
    effects = [name for name in library() if name not in without]
    recalibrated, fits = _fit_all(observations, effects, progress)
    outliers = _outliers(observations, min(fits, key=lambda f: f.objective))
    if outliers:
        excluded |= outliers
        observations = observations.subset(np.array([name not in outliers for name in observations.names]))
        recalibrated, fits = _fit_all(observations, effects, progress)
    fits = [recalibrated, *fits]
    probability = probabilities([evidence_of(f) for f in fits], observations.n_used)
    order = [0, *sorted(range(1, len(fits)), key=lambda i: -probability[i])]
    fits, probability = [fits[i] for i in order], probability[order]
    scored = explanations(fits, probability)
    credible = credible_set(scored)
    corrected = _corrected(fits, probability, scored[0].explanation)

    progress("holding out one condition after the other")
    measured = _measured_peaks(dataset, quality, observations)
    nominal = _unfitted(observations)
    try_on = partial(hold_out, observations, measured_peak=measured, scattered=corrected)
    held = {"nominal": try_on(nominal, refit=False), "recalibrated": try_on(recalibrated)}
    held["corrected"] = held["recalibrated"] if corrected is recalibrated else try_on(corrected)

    shrinkage = force_shrinkage(
        observations, held["recalibrated"], held["corrected"], _stretch(corrected), seed
    )
    if shrinkage and shrinkage.ci95[1] < HOPEFUL and _clear_gap(observations, held["recalibrated"]):
        scored = doubt(scored, shrinkage.value)
        credible = credible_set(scored)
        if (again := _corrected(fits, probability, scored[0].explanation)) is not corrected:
            corrected, held["corrected"] = again, try_on(again)
            shrinkage = force_shrinkage(
                observations, held["recalibrated"], held["corrected"], _stretch(corrected), seed
            )

    progress("asking what these trials can tell apart")
    detectability = tuple(separate.detectability(observations, recalibrated))
    leader = fits[0] if scored[0].explanation in ((), UNKNOWN) else corrected
    pairs = separate.confusable(observations, leader, _rivals(fits, leader)) if leader.explanation else []
    harmless = same_peaks(observations, recalibrated, [f for f in fits if _stands(f, credible)])
    verdict = _verdict(scored, credible, pairs, detectability, observations, harmless)
    no_gap = verdict == "no_gap"
    floor = _floor(observations, held["corrected"])
    return Diagnosis(
        dataset=dataset,
        quality=quality,
        observations=observations,
        verdict=verdict,
        scored=tuple(scored),
        credible=tuple(credible),
        component=components(fits, probability, scored),
        indistinguishable=tuple(pairs),
        absorbed={d.effect: d.absorbed for d in detectability},
        detectability=detectability,
        gap_map=gap_map(observations, recalibrated, held["recalibrated"]),
        gap={name: figures(observations, value) for name, value in held.items()},
        noise_floor_rms_n=floor,
        shrinkage_force=None if no_gap else shrinkage,
        shrinkage_peak=None
        if no_gap
        else peak_shrinkage(
            held["recalibrated"], held["corrected"], observations.condition, _stretch(corrected), seed
        ),
        fits=tuple(fits),
        probability=tuple(float(p) for p in probability),
        nominal=nominal,
        corrected=corrected,
        held=held,
        next_experiment=_next(observations, fits, probability, credible),
        excluded=excluded,
        warnings=(*quality.warnings, *_warnings(corrected)),
    )


def _fit_all(observations: Observations, effects: Sequence[str], progress: Progress) -> tuple[Fit, list[Fit]]:
    """The recalibrated model, every single effect and port, and the pairs that forward search finds."""
    progress("recalibrating the paper's model")
    recalibrated = candidates.fit_nominal(observations)
    progress("fitting every effect")
    tasks = [
        partial(candidates.fit_single, observations, recalibrated, name)
        for (name,) in candidates.singles(effects)
    ]
    fits = candidates.in_parallel(tasks)
    progress("searching for pairs")
    alone = [f for f in fits if not is_port(f.explanation) and np.isfinite(f.objective)]
    alone.sort(key=lambda f: f.objective)
    explained = 2 * alone[0].objective < UNEXPLAINED * observations.n_used
    wanted: dict[Explanation, tuple[Fit, str]] = {}
    for leader in alone[: LEADERS if explained else 2 * LEADERS]:
        for name, gain in candidates.partners(observations, leader, effects)[:PARTNERS]:
            if gain > WORTH_A_SECOND:
                wanted.setdefault(tuple(sorted((*leader.explanation, name))), (leader, name))
    fits += candidates.in_parallel(
        [partial(candidates.fit_more, observations, f, name) for f, name in wanted.values()]
    )
    # a simulation that broke down at every start explains nothing
    return recalibrated, [f for f in fits if np.isfinite(f.objective)]


def _outliers(observations: Observations, fitted: Fit) -> dict[str, str]:
    """Trials that even the best explanation does not fit while it fits the others."""
    samples = np.maximum(observations.used.sum(1), 1)
    ratio = fitted.chi2 / samples
    if len(ratio) < 5:
        return {}
    usual = float(np.median(ratio))
    beyond = fitted.chi2 - usual * samples > 40 + 8 * usual * np.sqrt(2 * samples)
    chosen = np.flatnonzero(beyond & (ratio > OUTLIER * usual))
    if len(chosen) > max(1, len(ratio) // 10):
        return {}
    # what every trial of a condition shows is physics, not a fault; a single one is given no such benefit
    condition = observations.condition
    groups = [np.flatnonzero(condition == condition[i]) for i in chosen]
    chosen = np.array(
        [i for i, g in zip(chosen, groups, strict=True) if len(g) == 1 or not np.isin(g, chosen).all()], int
    )
    return {
        observations.names[
            i
        ]: f"its misfit to the best explanation is {ratio[i] / usual:.0f} times that of the others"
        for i in chosen
    }


def _corrected(fits: Sequence[Fit], probability: np.ndarray, first: Explanation) -> Fit:
    """The fit behind the most probable explanation: of an unknown cause the best port's."""
    matching = [
        i
        for i, f in enumerate(fits)
        if (is_port(f.explanation) if first == UNKNOWN else f.explanation == first)
    ]
    return fits[max(matching, key=lambda i: probability[i])]


def _stretch(corrected: Fit) -> float:
    """By how much the interval of a shrinkage is wider than conditions left out one by one say."""
    return FREE_EXTRAPOLATION if is_port(corrected.explanation) else EXTRAPOLATION


def _unfitted(observations: Observations) -> Fit:
    """The paper's model at the rig's prior values."""
    return fit(observations, (), np.append(observations.prior.values, 0.0), warm=True, iterations=0)


def _rivals(fits: Sequence[Fit], leader: Fit) -> list[Fit]:
    """The explanations that could be confused with the leader: as many effects, all but one in common."""
    own = set(leader.explanation)
    return [
        f for f in fits if len(f.explanation) == len(own) and len(own & set(f.explanation)) >= len(own) - 1
    ]


def _verdict(
    scored: Sequence[Scored],
    credible: Sequence[Explanation],
    pairs: Sequence[separate.Pair],
    detectability: Sequence[separate.Detectability],
    observations: Observations,
    harmless: bool,
) -> str:
    first = scored[0].explanation
    blind = sum(d.distance_at_typical < DETECTABLE for d in detectability) > len(detectability) / 2
    if observations.peak_only.all() or (blind and first == ()):
        return "insufficient_data"
    if first == () and harmless:
        return "no_gap"
    if len(credible) >= TOO_MANY:
        return "insufficient_data"
    if first == ():
        return "ambiguous"
    if first == UNKNOWN:
        return "unknown"
    same = {first} | {p.effects[1] for p in pairs}
    return "identified" if set(credible) <= same else "ambiguous"


def _stands(fitted: Fit, credible: Sequence[Explanation]) -> bool:
    """Whether a fit belongs to an explanation of the credible set."""
    return (UNKNOWN if is_port(fitted.explanation) else fitted.explanation) in credible


def _clear_gap(observations: Observations, held: HeldOut) -> bool:
    """Whether the recalibrated model misses by more than what no model could predict."""
    used = observations.used & ~observations.peak_only[:, None]
    return bool((held.residual[used] ** 2).mean() > 2 * held.floor[used].mean())


def _measured_peaks(dataset: GapDataset, quality: Quality, observations: Observations) -> np.ndarray:
    """The largest sample within the impact phase of each trial, N."""
    by_name = {t.name: (t, q) for t, q in zip(dataset.trials, quality.trials, strict=True)}
    peaks = []
    for name in observations.names:
        trial, look = by_name[name]
        peaks.append(look.phase.peak_force if look.phase else trial.peak_force)
    return np.array(peaks, float)


def _floor(observations: Observations, held: HeldOut) -> float | None:
    used = observations.used & ~observations.peak_only[:, None]
    return float(np.sqrt(held.floor[used].mean())) if used.any() else None


def _next(
    observations: Observations, fits: Sequence[Fit], probability: np.ndarray, credible: Sequence[Explanation]
) -> Experiment | None:
    """The trial that best separates the two most probable explanations still standing."""
    standing = [(f, float(p)) for f, p in zip(fits, probability, strict=True) if _stands(f, credible)]
    if len(standing) < 2:
        return None
    standing.sort(key=lambda item: -item[1])
    return propose(observations, standing[0], standing[1])


def _warnings(corrected: Fit) -> list[str]:
    names = [name for name, _ in parameters(corrected.explanation)]
    return [
        f"{name} ended at its bound ({value:.4g}): its value is not determined by these trials"
        for name, value, bound in zip(names, corrected.theta, corrected.at_bound, strict=False)
        if bound
    ]

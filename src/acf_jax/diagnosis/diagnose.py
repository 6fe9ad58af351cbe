"""The whole diagnosis: quality, fits, probabilities, held-out figures, what cannot be told apart, what to do next."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from acf_jax.dataset import GapDataset, LowPass, Quality, assess_dataset
from acf_jax.dataset.filtered import assess_low_passed
from acf_jax.dataset.low_pass import approach_behind, thinned
from acf_jax.dataset.noise import approach_samples
from acf_jax.diagnosis import claims, damage, identifiability, motion, statements, strain
from acf_jax.diagnosis.candidates import best, fit_nominal, unfitted
from acf_jax.diagnosis.contributions import Contribution, contributions
from acf_jax.diagnosis.experiment import Experiment, propose
from acf_jax.diagnosis.explain import explain
from acf_jax.diagnosis.heldout import (
    CrossValidation,
    GapFigures,
    HeldOut,
    figures,
    form_error,
    hold_out,
)
from acf_jax.diagnosis.interim import Interim, Watch
from acf_jax.diagnosis.outliers import outliers
from acf_jax.diagnosis.search import fit_alone, fit_together, settled
from acf_jax.diagnosis.shrinkage import Belief, Shrinkage, held_out_left, peak_shrinkage
from acf_jax.diagnosis.trial_peaks import measured_peaks, same_peaks
from acf_jax.diagnosis.verdict import judge
from acf_jax.diagnosis.where import GapMap, gap_map
from acf_jax.effects import remaining
from acf_jax.evidence.marginal import Marginal
from acf_jax.evidence.posterior import UNKNOWN, Posterior, Scored, credible_set, posterior
from acf_jax.inference.discrepancy import FORMS
from acf_jax.inference.fit import Fit
from acf_jax.inference.free_curves import free_curves
from acf_jax.inference.observations import Observations, observe
from acf_jax.inference.parameters import Explanation, label
from acf_jax.inference.scatter import with_scatter

ONE_CONDITION = (
    "all trials were made at one condition: how far the gap shrinks elsewhere cannot be told;"
    " add trials at another contact velocity"
)
NOT_COMPARED = "its trace holds nothing to compare: no impact, or its end, lies behind first contact"

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Diagnosis:
    """Everything a diagnosis found; `report` and the command line write it out."""

    dataset: GapDataset
    quality: Quality
    observations: Observations
    verdict: str
    told: Posterior  # what is most probable first
    credible: tuple[Explanation, ...]
    component: dict[str, float]
    indistinguishable: tuple[identifiability.Pair, ...]
    detectability: tuple[identifiability.Detectability, ...]
    gap_map: GapMap
    gap: dict[str, GapFigures]
    noise_floor_rms_n: float | None
    comparison: claims.Comparison | None  # of corrected and recalibrated model; None where they are the same
    contributions: tuple[Contribution, ...]  # of the recalibrated model's gap; none where it has none
    form_error: dict[str, float]  # relative, of peaks on held-out conditions, by model
    shrinkage_force: Shrinkage | None
    shrinkage_peak: Shrinkage | None
    fits: tuple[Fit, ...]  # the paper's model first, the others most probable first
    probability: tuple[float, ...]  # of each fit
    evidence: tuple[Marginal, ...]  # what the probabilities rest on: each explanation beside each discrepancy
    nominal: Fit
    corrected: Fit
    held: dict[str, HeldOut]
    next_experiment: Experiment | None
    excluded: dict[str, str]
    highest: float  # above which no probability is stated, since data are damaged; 1: none is
    warnings: tuple[str, ...] = field(default=())

    @property
    def scored(self) -> tuple[Scored, ...]:
        """The explanations as they are stated, the most probable first."""
        return self.told.scored


def diagnose(
    dataset: GapDataset,
    seed: int = 0,
    progress: Progress = lambda stage: None,
    without: Collection[str] = (),
    low_pass: LowPass | None = None,
    watch: Watch | None = None,
) -> Diagnosis:
    """Where the gap between the paper's model and measured impacts lies, why, and how far it shrinks.

    **Arguments:** `dataset`: as `read_dataset` gives it, or built from arrays. `seed`: of the bootstrap; the same seed
    gives the same answer. `progress`: called with the name of each stage as it begins. `without`: effects that cannot
    be the cause, and components that the rig does not have ("robot", ...). `low_pass`: a filter for data
    and model, to leave out what is faster than any cause that is asked for, as a ring; then `Diagnosis.dataset` holds
    what came out of it. `watch`: told what is known before all is, see `acf_jax.diagnosis.interim`.

    **Returns:** a `Diagnosis`. Needs float64 (`jax_enable_x64`).

    **Raises:** `InputError` when fewer than three trials can be used, `ValueError` where `without` names no effect.
    """
    without = [without] if isinstance(without, str) else without
    effects = remaining(without)
    curves = [name for name, cls in free_curves().items() if cls.component not in without]
    progress("looking at the data")
    names = [trial.name for trial in dataset.trials]
    quality = assess_low_passed(dataset, low_pass) if low_pass else assess_dataset(dataset)
    dataset = quality.dataset if low_pass else dataset
    observed = observe(quality)
    excluded = dict(quality.excluded)
    for name in names:
        if name not in observed.names:
            excluded.setdefault(name, NOT_COMPARED)
    interim = Interim(watch)
    interim.trust(quality, excluded)
    observations, recalibrated, fits = _fit(quality, observed, [*effects, *curves], progress, interim)
    left_out = outliers(observations, [recalibrated, *fits])
    if left_out:
        excluded |= left_out
        kept = np.array([name not in left_out for name in observations.names])
        interim.trust(quality, excluded)
        observed = observed.subset(kept)
        observations, recalibrated, fits = _fit(quality, observed, [*effects, *curves], progress, interim)
    progress("asking what the noise is like")
    traces = [t.trace for t in quality.dataset.trials if t.trace and t.name in observations.names]
    before = [approach_samples(trace) for trace in traces]
    if band := observations.low_pass:
        before = [thinned(approach_behind(trace, band), band) for trace in traces]
    observations, fits = settled(observations, [recalibrated, *fits], before)
    progress("weighing explanations")
    interim.anew()
    fits, evidence = explain(observations, fits, effects, interim.weighed)
    sure = posterior(evidence)
    recalibrated = fits[0]
    corrected = _corrected(fits, np.array([sure.of(f.explanation) for f in fits]), sure)

    progress("holding out one condition after the other")
    measured = measured_peaks(quality, observations)
    nominal = unfitted(observations)
    validation = CrossValidation(observations, measured, recalibrated, corrected)
    held = {
        "nominal": hold_out(observations, nominal, measured, validation.scattered, refit=False),
        "recalibrated": validation.of(recalibrated),
        "corrected": validation.of(corrected),
    }
    gap = {
        name: figures(observations, value)
        if validation.is_possible or name == "nominal"
        else GapFigures(None, None, None)
        for name, value in held.items()
    }
    comparison = None
    if corrected is not recalibrated:
        own = hold_out(observations, corrected, measured, validation.scattered, refit=False)
        comparison = claims.compare(gap["recalibrated"], gap["corrected"], figures(observations, own))
    floor = _floor(observations, held["corrected"])
    highest = damage.highest_probability(quality, observations.names)
    believed, is_denied = 1.0, False
    if comparison is not None and sure.scored[0].explanation != UNKNOWN:
        is_missing = sure.missed > FORMS
        believed = claims.highest_probability(comparison, floor, is_missing)
        is_denied = comparison.is_denied and not is_missing
    told = damage.tempered(sure, min(highest, believed))
    scored, credible = told.scored, credible_set(told.scored)
    probability = np.array([told.of(f.explanation) for f in fits])
    first = scored[0]
    right = 0.0 if first.explanation == UNKNOWN else first.probability
    belief = Belief(right, told.discrepancy[first.explanation])
    left = held_out_left(validation, corrected, belief, seed)
    shrinkage = None if left is None else Shrinkage.of(left)
    order = [0, *sorted(range(1, len(fits)), key=lambda i: -probability[i])]
    fits, probability = [fits[i] for i in order], probability[order]

    progress("asking what these trials can tell apart")
    detectability = tuple(identifiability.detectability(observations, recalibrated, effects))
    leader = fits[0] if scored[0].explanation in ((), UNKNOWN) else corrected
    rivals = [f for f in _rivals(fits, leader) if told.stated(f.explanation) != first.explanation]
    pairs = identifiability.confusable(observations, leader, rivals) if leader.explanation else []
    pairs = identifiability.stated(pairs, told)
    standing = [f for f in fits if told.stated(f.explanation) in credible]
    harmless = same_peaks(observations, recalibrated, standing)
    verdict = judge(scored, credible, pairs, detectability, observations, harmless)
    tells_gap = verdict not in ("no_gap", "insufficient_data")
    is_stated = comparison is not None and comparison.is_better and tells_gap
    component = told.components()
    form = {name: form_error(held[name], observations.noise.std) for name in ("recalibrated", "corrected")}
    return Diagnosis(
        dataset=dataset,
        quality=quality,
        observations=observations,
        verdict=verdict,
        told=told,
        credible=tuple(credible),
        component=component,
        indistinguishable=tuple(pairs),
        detectability=detectability,
        gap_map=gap_map(observations, recalibrated, held["recalibrated"]),
        gap=gap,
        noise_floor_rms_n=floor,
        comparison=comparison,
        contributions=contributions(
            observations, fits, corrected, held, left, scored, component, effects, seed
        ),
        form_error=form,
        shrinkage_force=claims.agreeing(shrinkage, gap["recalibrated"], gap["corrected"], floor)
        if is_stated
        else None,
        shrinkage_peak=_peak_shrinkage(observations, held, seed) if is_stated else None,
        fits=tuple(fits),
        probability=tuple(float(p) for p in probability),
        evidence=tuple(evidence),
        nominal=nominal,
        corrected=corrected,
        held=held,
        next_experiment=_next(observations, standing, told),
        excluded=excluded,
        highest=highest,
        warnings=(
            *quality.warnings,
            *damage.statements(quality, observations.names, highest),
            *map(statements.of_ring, observations.rings),
            *statements.of_scatter(quality.noise.std, observations),
            *filter(None, [strain.statement(strain.strains(recalibrated, observations.prior))]),
            *filter(None, [_doubt(first.explanation, corrected, observations)]),
            *filter(None, [motion.statement(observations, recalibrated)]),
            *statements.of_discrepancy(told),
            *statements.of_minor(corrected, told),
            *statements.of_model(comparison, form["corrected"]),
            *(statements.of_denial(first.explanation) if is_denied else ()),
            *statements.of_bounds(corrected),
            *([] if validation.is_possible else [ONE_CONDITION]),
        ),
    )


def _fit(
    quality: Quality, observed: Observations, causes: Sequence[str], progress: Progress, interim: Interim
) -> tuple[Observations, Fit, list[Fit]]:
    """The observations with what repeats show of scatter, the recalibrated model, and what is fitted beside it.

    What rings, and what repeats differ by besides, is told beside the best single cause: then all are fitted again.
    """
    observations = with_scatter(observed)
    recalibrated, fits = _alone(quality, observations, causes, progress, interim)
    found = with_scatter(observed, best(fits))
    if found.rings or found.noise != observations.noise:
        observations = found
        recalibrated, fits = _alone(quality, observations, causes, progress, interim)
    progress("searching for pairs")
    return observations, recalibrated, fit_together(observations, recalibrated, fits, interim.fitted)


def _alone(
    quality: Quality,
    observations: Observations,
    causes: Sequence[str],
    progress: Progress,
    interim: Interim,
) -> tuple[Fit, list[Fit]]:
    """The recalibrated model, and every cause alone beside it."""
    interim.anew()
    progress("recalibrating the paper's model")
    recalibrated = fit_nominal(observations)
    interim.gap(observations, measured_peaks(quality, observations), unfitted(observations), recalibrated)
    interim.fitted([recalibrated])
    progress("fitting every effect")
    return recalibrated, fit_alone(observations, recalibrated, causes, interim.fitted)


def _corrected(fits: Sequence[Fit], probability: np.ndarray, told: Posterior) -> Fit:
    """The most probable fit behind the most probable explanation: of an unknown cause the best free curve's.

    The recalibrated model where every free curve breaks down.
    """
    first = told.scored[0].explanation
    matching = [i for i, f in enumerate(fits) if told.stated(f.explanation) == first]
    return fits[max(matching, key=lambda i: probability[i], default=0)]


def _rivals(fits: Sequence[Fit], leader: Fit) -> list[Fit]:
    """The explanations that could be confused with the leader: as many effects, all but one in common."""
    own = set(leader.explanation)
    return [
        f for f in fits if len(f.explanation) == len(own) and len(own & set(f.explanation)) >= len(own) - 1
    ]


def _floor(observations: Observations, held: HeldOut) -> float | None:
    used = observations.traced
    return float(np.sqrt(held.floor[used].mean())) if used.any() else None


def _next(observations: Observations, standing: Sequence[Fit], told: Posterior) -> Experiment | None:
    """The trial that best separates the two most probable explanations still standing, each by its best fit."""
    best: dict[Explanation, tuple[Fit, float]] = {}
    for fitted in sorted(standing, key=lambda f: -told.of(f.explanation)):
        best.setdefault(told.stated(fitted.explanation), (fitted, told.of(fitted.explanation)))
    if len(best) < 2:
        return None
    (first, one), (second, other), *_ = best.items()
    found = propose(observations, one, other)
    return found and replace(found, separates=(first, second))


def _peak_shrinkage(observations: Observations, held: dict[str, HeldOut], seed: int) -> Shrinkage | None:
    """How far the error of the peak shrinks; None where it does not."""
    found = peak_shrinkage((held["recalibrated"], held["corrected"]), observations.condition, seed)
    return found if found and found.value > 0 else None


def _doubt(named: Explanation, corrected: Fit, observations: Observations) -> str:
    """What speaks against the laws named: they leave the rig strained."""
    if named in ((), UNKNOWN):
        return ""
    return strain.doubt(strain.strains(corrected, observations.prior), label(named).lower())

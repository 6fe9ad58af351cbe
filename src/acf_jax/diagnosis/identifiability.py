"""Which explanations these trials can tell apart, whatever the data say: computed on predictions alone."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.stats import norm

from acf_jax.diagnosis.candidates import best, in_parallel
from acf_jax.effects import library
from acf_jax.evidence.posterior import Posterior
from acf_jax.inference.baseline import Ground
from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.linear import linearise
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import (
    RIG,
    Explanation,
    Measures,
    every_effect,
    is_free_curve,
    parameters,
    starts,
)

BAYES_ERROR = 0.10  # two explanations count as indistinguishable above it
ENOUGH = 1e-3  # share of the squared distance that an iteration has to gain; the error needs no more digits
DETECTABLE = 3.0  # standard deviations: a whitened distance below it cannot be told from noise
NOTHING = 1e-2  # standard deviations: less is rounding


@dataclass(frozen=True)
class Pair:
    """Two explanations and the error of the best possible decision between them, both equally probable."""

    effects: tuple[Explanation, Explanation]
    bayes_error: float


def bayes_error(distance: float) -> float:
    """Q(d/2): how often the best rule confuses two signals at the whitened distance d."""
    return float(norm.sf(distance / 2))


def misfit(fitted: Fit) -> float:
    """What a fit to noise-free forces leaves, in chi-square: the prior of an effect's own parameters does not count."""
    return float(2 * fitted.objective - (_of_effects(fitted) ** 2).sum())


def _of_effects(fitted: Fit) -> np.ndarray:
    return fitted.u[len(RIG) : len(parameters(fitted.explanation))]


def confusable(observations: Observations, truth: Fit, fits: Sequence[Fit]) -> list[Pair]:
    """The explanations that would have been confused with `truth`, had it been exactly true at its fitted size.

    Each other explanation is fitted to the noise-free predictions of `truth`; what it cannot imitate is the distance.
    """
    quiet = np.zeros((len(observations.names), observations.n_nuisances))
    linear = linearise(observations, truth.explanation, truth.coordinates, truth.u, quiet, truth.grid)
    ideal = replace(observations, force=np.where(observations.used, linear.predicted, observations.force))
    prior = float((truth.u**2).sum() - (_of_effects(truth) ** 2).sum())

    def imitate(other: Fit) -> Fit:
        guesses = [other.theta]
        if len(other.explanation) == 1:
            guesses += [
                np.concatenate([truth.theta[: len(RIG)], s, truth.common])
                for s in starts(other.explanation[0], ideal.measures)[:1]
            ]
        again = partial(fit, ideal, other.explanation, tolerance=ENOUGH, program=other.program)
        return best(map(again, guesses))

    others = [f for f in fits if f.explanation != truth.explanation and not is_free_curve(f.explanation)]
    imitations = in_parallel([partial(imitate, f) for f in others])
    pairs = []
    for other in imitations:
        # the prior's cost of the true rig is paid by both
        error = bayes_error(np.sqrt(max(0.0, misfit(other) - prior)))
        if error > BAYES_ERROR:
            pairs.append(Pair((truth.explanation, other.explanation), error))
    return sorted(pairs, key=lambda p: -p.bayes_error)


def stated(pairs: Sequence[Pair], told: Posterior) -> list[Pair]:
    """Pairs of what was weighed as they are stated, of those that are stated alike the one that is confused most."""
    found: dict[tuple[Explanation, Explanation], Pair] = {}
    for pair in pairs:
        first, second = map(told.stated, pair.effects)
        found.setdefault((first, second), replace(pair, effects=(first, second)))
    return list(found.values())


def _by_first_strength(name: str, measures: Measures) -> list[list[float]]:
    """The starts of an effect, every strength but the first one at zero: it is the size that is spoken of."""
    known = every_effect()[name].parameters()
    return [
        [value if k == 0 or p.shape else 0.0 for k, (p, value) in enumerate(zip(known, start, strict=True))]
        for start in starts(name, measures)
    ]


@dataclass(frozen=True)
class Detectability:
    """What a design of trials could say of one effect.

    Its size is its first strength, and only where that alone moves nothing all its strengths in proportion.
    """

    effect: str
    smallest: float | None  # own unit; detected with three standard deviations; None: beyond its range
    unit: str
    distance_at_typical: float  # whitened distance of the typical size from all that the rig could imitate
    confused_with: tuple[str, ...]  # effects that these trials could not tell apart at the typical size
    absorbed: float  # share of the signature that the nominal parameters could imitate, 0 to 1


def detectability(observations: Observations, nominal: Fit, effects: Sequence[str]) -> list[Detectability]:
    """For each effect, whether these trials could detect it and which effects they could not tell apart from it."""
    ground = Ground.of(observations, nominal)
    found = in_parallel([partial(_shown, ground, name) for name in effects])
    seen = {name: shown for name, shown in zip(effects, found, strict=True) if shown is not None}
    names, signals = list(seen), [signal for signal, _, _ in seen.values()]
    gram = ground.projector.gram(np.stack(signals))
    distance = np.sqrt(np.maximum(np.diag(gram), 0.0))
    cosine = gram / np.maximum(np.outer(distance, distance), 1e-12)
    apart = np.minimum.outer(distance, distance) * np.sqrt(np.maximum(1 - cosine**2, 0.0))
    result = []
    for i, name in enumerate(names):
        confused = [names[j] for j in range(len(names)) if j != i and bayes_error(apart[i, j]) > BAYES_ERROR]
        first = library()[name].parameters()[0]
        is_within = DETECTABLE * first.scale < distance[i] * first.high
        smallest = float(DETECTABLE * first.scale / distance[i]) if is_within else None
        result.append(
            Detectability(name, smallest, first.unit, float(distance[i]), tuple(confused), seen[name][1])
        )
    return result


def _shown(ground: Ground, name: str) -> tuple[np.ndarray, float, float] | None:
    """What an effect of typical size shows, as of `_typical`: its first strength, or all where that moves nothing."""
    measures = ground.observations.measures
    shown = _typical(ground, name, _by_first_strength(name, measures))
    return (
        _typical(ground, name, starts(name, measures)) if shown is not None and shown[2] < NOTHING else shown
    )


def _typical(ground: Ground, name: str, begins: list[list[float]]) -> tuple[np.ndarray, float, float] | None:
    """The signature (trials, n) of an effect's typical size, from the start that shows most.

    With it the share of its signature that is absorbed, and its whitened distance.
    """
    found = list(ground.signatures(name, begins))
    if not found:
        return None
    left = np.array([ground.projector.gram(s[None])[0, 0] for _, s in found])
    whole = np.array([ground.projector.gram_of_nuisances(s[None])[0, 0] for _, s in found])
    start, strongest = found[int(np.argmax(left))]
    typical = library()[name].parameters()[0].scale / (abs(start[0]) or 1.0)
    absorbed = float(np.clip(1 - (left / np.maximum(whole, 1e-12)).min(), 0.0, 1.0))
    return strongest * typical, absorbed, float(np.sqrt(max(left.max(), 0.0)) * typical)

"""From log scores to probabilities of explanations and of components, and to the credible set."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from acf_jax.evidence.scores import WEIGHTS, Evidence, Weights, log_scores, misfit_cost, strain_cost
from acf_jax.inference.fit import Fit
from acf_jax.inference.parameters import Explanation, component_of, is_free_curve

UNKNOWN: Explanation = ("unknown",)
CREDIBLE = 0.95
CONVINCING = 0.4  # shrinkage on held-out conditions below which an explanation is doubted
IN_SERIES = ("robot", "sensor")  # components that all of the contact force passes
HIGHEST = 0.995  # no probability is stated higher: a world outside these models always remains


@dataclass(frozen=True)
class Scored:
    """An explanation with its probability; an unknown cause carries the component of each of its fits."""

    explanation: Explanation
    probability: float


def probabilities(
    evidence: Sequence[Evidence], samples: int, weights: Weights = WEIGHTS, noise_doubt: float = 0.0
) -> np.ndarray:
    """Probability of each explanation, (n,), none above `HIGHEST`; a nameless cause counts with the free curves."""
    score = log_scores(evidence, samples, weights, noise_doubt)
    p = np.exp(score - score.max())
    p /= p.sum()
    named = p[:-1]
    is_curve = np.array([is_free_curve(e.explanation) for e in evidence])
    if is_curve.any():
        share = _curve_shares(
            [e for e in evidence if is_free_curve(e.explanation)], evidence[0].chi_square, samples, weights
        )
        named[is_curve] = (named[is_curve].sum() + p[-1]) * share
    return capped(named / named.sum())


def _curve_shares(fits: Sequence[Evidence], whole: float, samples: int, weights: Weights) -> np.ndarray:
    """Where an unknown cause acts: the probability of each free curve, `whole` the chi-square of no explanation.

    It is told by how well each curve fits, and by what its rig had to do for that. Robot and sensor stand in series
    with everything, so their curves can imitate most of what happens elsewhere. Where even the best one leaves much,
    that it is the best says little.
    """
    left = np.array([e.chi_square for e in fits])
    wrong = weights.rho_squared * max(whole - left.min(), 0.0) + max(left.min() - samples, 0.0)
    in_series = np.array([component_of(e.explanation[0]) in IN_SERIES for e in fits])
    score = (
        -misfit_cost(left - left.min(), wrong, weights.nu, samples)
        - weights.strain_told * strain_cost(fits, weights)
        - weights.in_series * in_series
    )
    share = np.exp(score - score.max())
    return np.asarray(share / share.sum())


def explanations(fits: Sequence[Fit], probability: np.ndarray) -> list[Scored]:
    """The explanations, most probable first, the four free curves together as `unknown`."""
    total: dict[Explanation, float] = {}
    for fitted, p in zip(fits, probability, strict=True):
        name = UNKNOWN if is_free_curve(fitted.explanation) else fitted.explanation
        total[name] = total.get(name, 0.0) + float(p)
    return ranked(total)


def ranked(total: dict[Explanation, float]) -> list[Scored]:
    """Most probable first, none above `HIGHEST`."""
    names, p = list(total), np.array(list(total.values()))
    return sorted(map(Scored, names, capped(p).tolist()), key=lambda s: (-s.probability, s.explanation))


def capped(p: np.ndarray) -> np.ndarray:
    """Probabilities of which none is above `HIGHEST`: what is too much is shared out evenly."""
    if p.max() <= HIGHEST or len(p) == 1:
        return p
    excess = (p.max() - HIGHEST) / (p.max() - 1 / len(p))
    return np.asarray((1 - excess) * p + excess / len(p))


def credible_set(scored: Sequence[Scored]) -> list[Explanation]:
    """The smallest set of explanations that holds 95 %."""
    chosen: list[Explanation] = []
    total = 0.0
    for s in scored:
        chosen.append(s.explanation)
        total += s.probability
        if total >= CREDIBLE:
            break
    return chosen


def doubt(scored: Sequence[Scored], shrinkage: float) -> list[Scored]:
    """The explanations after a look at unseen conditions: what does not shrink a clear gap there is not its cause.

    Of the leading explanation's probability the share that its shrinkage falls short of `CONVINCING` goes to `unknown`.
    """
    first = scored[0]
    kept = min(1.0, max(0.0, shrinkage / CONVINCING))
    if first.explanation in ((), UNKNOWN) or kept == 1.0:
        return list(scored)
    total = {s.explanation: s.probability for s in scored}
    total[first.explanation] *= kept
    total[UNKNOWN] = total.get(UNKNOWN, 0.0) + first.probability - total[first.explanation]
    return ranked(total)


def of_each_fit(fits: Sequence[Fit], probability: np.ndarray, scored: Sequence[Scored]) -> np.ndarray:
    """Probability (n,) of each fit as its explanation's is stated; the free curves share theirs as they did before."""
    stated = {s.explanation: s.probability for s in scored}
    is_curve = np.array([is_free_curve(f.explanation) for f in fits])
    share = np.where(is_curve, np.maximum(probability, 1e-300), 0.0)
    share /= max(share.sum(), 1e-300)
    return np.array(
        [
            stated[UNKNOWN] * part if part else stated[f.explanation]
            for f, part in zip(fits, share.tolist(), strict=True)
        ]
    )


def components(fits: Sequence[Fit | Evidence], probability: np.ndarray) -> dict[str, float]:
    """Probability that a cause acts at each component; a pair counts at both, an unknown cause as its curves say."""
    total = dict.fromkeys(("actuator", "contact", "robot", "sensor"), 0.0)
    for fitted, p in zip(fits, probability, strict=True):
        for component in {component_of(name) for name in fitted.explanation}:
            total[component] += float(p)
    return total

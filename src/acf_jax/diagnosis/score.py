"""From fits to probabilities: how much each explanation leaves, and what that says when no form is exact."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from acf_jax.diagnosis.fit import Fit
from acf_jax.diagnosis.ports import ports
from acf_jax.diagnosis.space import Explanation, component_of

UNKNOWN: Explanation = ("unknown",)
CREDIBLE = 0.95
HIGHEST = 0.995  # no probability is stated higher: a world outside these models always remains


@dataclass(frozen=True)
class Weights:
    """How evidence becomes probability, learnt on simulated cases (docs/calibration.md says how).

    An effect whose true form differs from the library's leaves some of the gap even when it is the cause. So the
    half chi-square x/2 that an explanation leaves above the best one counts as
    nu/2 log(1 + x / (nu + rho^2 G)), G the chi-square of the whole gap: the likelihood itself for a small gap, and no
    more than about nu/2 for each factor of e by which it fits worse than form errors of the relative size rho.
    """

    nu: float = 40.0  # how many independent pieces a misfit of form has
    rho_squared: float = 0.02  # the share of the gap that a wrong form leaves
    effect: float = 3.5  # cost of one effect, in log probability
    second: float = 5.0  # cost of each further one
    port: float = 9.0  # cost of an unknown cause


WEIGHTS = Weights()


@dataclass(frozen=True)
class Scored:
    """An explanation with its probability; an unknown cause carries the port of each of its fits."""

    explanation: Explanation
    probability: float


def is_port(explanation: Explanation) -> bool:
    """Whether the explanation is the free discrepancy at a port."""
    return bool(explanation) and explanation[0] in ports()


def cost(explanation: Explanation, weights: Weights = WEIGHTS) -> float:
    """Log probability that an explanation has less than the paper's model before any data."""
    if not explanation:
        return 0.0
    if is_port(explanation):
        return weights.port
    return weights.effect + weights.second * (len(explanation) - 1)


def log_scores(fits: Sequence[Fit], samples: int, weights: Weights = WEIGHTS) -> np.ndarray:
    """Unnormalised log probability of each fit; the first one has to be the paper's model alone."""
    chi2 = 2 * np.array([f.objective for f in fits])
    noise = max(1.0, chi2.min() / samples)  # what nothing explains is taken as noise
    excess, gap = (chi2 - chi2.min()) / noise, (chi2[0] - chi2.min()) / noise
    evidence = 0.5 * weights.nu * np.log1p(excess / (weights.nu + weights.rho_squared * gap))
    return -evidence - np.array([cost(f.explanation, weights) for f in fits])


def probabilities(fits: Sequence[Fit], samples: int, weights: Weights = WEIGHTS) -> np.ndarray:
    """Probability of each fit, shape (fits,), capped at `HIGHEST`."""
    score = log_scores(fits, samples, weights)
    p = np.exp(score - score.max())
    p /= p.sum()
    rest = np.ones(len(p)) / len(p)
    excess = max(0.0, (p.max() - HIGHEST) / (p.max() - 1 / len(p)))
    return (1 - excess) * p + excess * rest


def explanations(fits: Sequence[Fit], probability: np.ndarray) -> list[Scored]:
    """The explanations, most probable first, the four ports together as `unknown`."""
    total: dict[Explanation, float] = {}
    for fitted, p in zip(fits, probability, strict=True):
        name = UNKNOWN if is_port(fitted.explanation) else fitted.explanation
        total[name] = total.get(name, 0.0) + float(p)
    ranked = sorted(total.items(), key=lambda item: (-item[1], item[0]))
    return [Scored(name, p) for name, p in ranked]


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


def components(fits: Sequence[Fit], probability: np.ndarray) -> dict[str, float]:
    """Probability that a cause acts at each component; a pair counts at both of its components."""
    total = dict.fromkeys(("actuator", "contact", "robot", "sensor"), 0.0)
    for fitted, p in zip(fits, probability, strict=True):
        for component in {component_of(name) for name in fitted.explanation}:
            total[component] += float(p)
    return total

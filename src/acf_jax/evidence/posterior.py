"""From marginal likelihoods to probabilities of explanations and of components, and to the credible set.

The evidence of an explanation is its marginal likelihood, beside some size of a discrepancy that stands for forms which
are not exact. No model of the data is exact either: neighbouring samples share their errors, so that log evidence is
surer than it is right. It is divided by a temperature, as in a power posterior (Gruenwald and van Ommen, 'Inconsistency
of Bayesian inference for misspecified linear models, and a proposal for repairing it', Bayesian Analysis 12, 2017).

Laws that explain less than they cost beside others are no answer of their own: they are left out (Occam's window:
Madigan and Raftery, 'Model selection and accounting for model uncertainty', J. Am. Stat. Assoc. 89, 1994).

What no explanation has is often refitted into the rig. A rig far from what is known of it therefore speaks for an
unknown cause, however well the explanation fits (prior-data conflict: Box, 'Sampling and Bayes' inference in scientific
modelling and robustness', J. R. Stat. Soc. A 143, 1980).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import expit, softmax

from acf_jax.evidence.learnt import LEARNT, Learnt
from acf_jax.evidence.marginal import Marginal
from acf_jax.inference.parameters import RIG, Explanation, component_of, is_free_curve, split

UNKNOWN: Explanation = ("unknown",)
CREDIBLE = 0.95


class Scored(NamedTuple):
    """An explanation with its probability; the free curves together are `UNKNOWN`."""

    explanation: Explanation
    probability: float


class Posterior(NamedTuple):
    """The probabilities of all that was weighed."""

    scored: tuple[Scored, ...]  # explanations, most probable first
    curve: dict[Explanation, float]  # of an unknown cause: the share of each free curve, alone or beside laws
    discrepancy: dict[
        Explanation, dict[float, float]
    ]  # of each explanation: the probability of each size beside it

    def of(self, explanation: Explanation) -> float:
        """Probability of a fitted explanation; a free curve has its share of an unknown cause."""
        share = self.curve.get(explanation, 0.0) if is_free_curve(explanation) else 1.0
        return share * dict(self.scored).get(stated(explanation), 0.0)

    def components(self) -> dict[str, float]:
        """Probability that a cause acts at each component.

        Several laws count each; an unknown cause where its free curve does, whatever laws stand beside that.
        """
        total = dict.fromkeys(("actuator", "contact", "robot", "sensor"), 0.0)
        for s in self.scored:
            if s.explanation == UNKNOWN:
                for explanation, share in self.curve.items():
                    _, (curve,) = split(explanation)
                    total[component_of(curve)] += share * s.probability
            else:
                for component in {component_of(name) for name in s.explanation}:
                    total[component] += s.probability
        return total


def stated(explanation: Explanation) -> Explanation:
    """An explanation as it is stated: a free curve is an unknown cause, alone or beside laws."""
    return UNKNOWN if is_free_curve(explanation) else explanation


def cost(explanation: Explanation, learnt: Learnt = LEARNT) -> float:
    """Log probability that an explanation has less than the paper's model before any data."""
    laws, curves = split(explanation)
    return learnt.effect * len(laws) + learnt.free_curve * len(curves)


def log_posterior(marginals: Sequence[Marginal], learnt: Learnt = LEARNT) -> np.ndarray:
    """Unnormalised log probability (n,) of each explanation beside its discrepancy, of which none is preferred."""
    return np.array([m.log_z / learnt.temperature - cost(m.explanation, learnt) for m in marginals])


def hidden(m: Marginal, learnt: Learnt = LEARNT) -> float:
    """Probability that besides what an explanation has an unknown cause hides in its rig, were nothing else possible.

    Then each constant of the rig lies `hiding` standard deviations from what is known of it, not one. A free curve is
    unknown already.
    """
    if is_free_curve(m.explanation):
        return 0.0
    wide = learnt.hiding
    log_odds = 0.5 * m.strain * (1 - wide**-2) - len(RIG) * np.log(wide) - learnt.free_curve
    return float(expit(log_odds))


def in_window(marginals: Sequence[Marginal], learnt: Learnt = LEARNT) -> list[Marginal]:
    """Those of explanations of which no part, that names a law, is more probable.

    That nothing is unmodelled is no such part: it is another answer.
    """
    best: dict[Explanation, float] = {}
    for m, value in zip(marginals, log_posterior(marginals, learnt).tolist(), strict=True):
        best[m.explanation] = max(value, best.get(m.explanation, -np.inf))
    laws = {e: value for e, value in best.items() if e and not is_free_curve(e)}
    outside = {
        whole
        for whole, value in laws.items()
        if any(set(part) < set(whole) and more > value for part, more in laws.items())
    }
    return [m for m in marginals if m.explanation not in outside]


def posterior(marginals: Sequence[Marginal], learnt: Learnt = LEARNT) -> Posterior:
    """The probability of every explanation, whatever the discrepancy."""
    marginals = in_window(marginals, learnt)
    log_p = log_posterior(marginals, learnt)
    p = np.exp(log_p - log_p.max())
    beside: dict[Explanation, dict[float, float]] = {}
    tiny = float(np.finfo(float).tiny)
    for m, value in zip(marginals, (p / p.sum()).tolist(), strict=True):
        unknown = value * hidden(m, learnt)
        for explanation, part in ((stated(m.explanation), value - unknown), (UNKNOWN, unknown)):
            sizes = beside.setdefault(explanation, {})
            sizes[m.discrepancy] = sizes.get(m.discrepancy, tiny) + part
    total = {e: sum(sizes.values()) for e, sizes in beside.items()}
    return Posterior(
        ranked(total),
        _among_curves(marginals, log_p),
        {e: {size: value / total[e] for size, value in sizes.items()} for e, sizes in beside.items()},
    )


def _among_curves(marginals: Sequence[Marginal], log_p: np.ndarray) -> dict[Explanation, float]:
    """The share of each free curve in an unknown cause, also where a law is more probable than all by any factor."""
    log_share: dict[Explanation, float] = {}
    for m, value in zip(marginals, log_p.tolist(), strict=True):
        if is_free_curve(m.explanation):
            log_share[m.explanation] = float(np.logaddexp(log_share.get(m.explanation, -np.inf), value))
    shares = np.maximum(softmax(list(log_share.values())), np.finfo(float).tiny) if log_share else np.empty(0)
    return dict(zip(log_share, shares.tolist(), strict=True))


def ranked(total: dict[Explanation, float]) -> tuple[Scored, ...]:
    """Most probable first."""
    return tuple(
        sorted((Scored(e, p) for e, p in total.items()), key=lambda s: (-s.probability, s.explanation))
    )


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

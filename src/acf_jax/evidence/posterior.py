"""From marginal likelihoods to probabilities of explanations and of components, and to the credible set.

The evidence of an explanation is its marginal likelihood, beside some size of a discrepancy that stands for forms which
are not exact. No model of the data is exact either. Where conditions disagree about which explanation is the better
one, others might have said something else: probabilities are those of data sets drawn anew from the conditions, on
average (Huggins and Miller, 'Reproducible model selection using bagged posteriors', Bayesian Analysis 18, 2023).

Before any data it is as likely as not that an unknown cause acts, and as likely at each component. No law and every
number of laws are as likely, and so are all combinations of as many: the more there are, the better the best of them
fits by chance (Scott and Berger, 'Bayes and empirical-Bayes multiplicity adjustment in the variable-selection problem',
Annals of Statistics 38, 2010).

An explanation is stated by the laws that matter. Small ones stand in for one another, and for what the forms of the
large ones get wrong: they are background, unless data need them where those forms may be wrong. Where much is missing,
each law may stand in for what misses: an explanation without a likely one counts as an unknown cause.
"""

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import log_softmax, logsumexp, softmax

from acf_jax.effects import COMPONENTS, library
from acf_jax.evidence.marginal import Marginal
from acf_jax.inference.discrepancy import FORMS
from acf_jax.inference.parameters import Explanation, component_of, is_free_curve, split

UNKNOWN: Explanation = ("unknown",)
CREDIBLE = 0.95  # as intervals: the share of the probability, or of what laws change, that counts as all
# share of the probability of laws from which on one is likely: three to one is the least that Kass and Raftery call
# positive evidence, of a Bayes factor ('Bayes factors', Journal of the American Statistical Association 90, 1995)
POSITIVE = 0.75
DATA_SETS = 500  # drawn from the conditions: a probability of a half is told to 2 %
TINY = float(np.finfo(float).tiny)  # odds of any two explanations exist


class Scored(NamedTuple):
    """An explanation as it is stated, with its probability; the free curves together are `UNKNOWN`."""

    explanation: Explanation
    probability: float


class Posterior(NamedTuple):
    """The probabilities of all that was weighed."""

    scored: tuple[Scored, ...]  # explanations as they are stated, most probable first
    behind: dict[
        Explanation, dict[Explanation, float]
    ]  # of each, what was weighed: its share of the probability
    discrepancy: dict[
        Explanation, dict[float, float]
    ]  # of each explanation: the probability of each size beside it

    @property
    def missed(self) -> float:
        """The share of the force by which the first explanation misses it, most probably: the discrepancy's size."""
        sizes = self.discrepancy[self.scored[0].explanation]
        return max(sizes, key=lambda size: sizes[size])

    def stated(self, explanation: Explanation) -> Explanation:
        """How what was weighed is stated."""
        return next((told for told, shares in self.behind.items() if explanation in shares), explanation)

    def of(self, explanation: Explanation) -> float:
        """Probability of what was weighed: its share of what it is stated as."""
        told = self.stated(explanation)
        return self.behind.get(told, {}).get(explanation, 0.0) * dict(self.scored).get(told, 0.0)

    def components(self) -> dict[str, float]:
        """Probability that a cause acts at each component.

        Each law that is stated counts, no other; an unknown cause where its free curve acts, whatever laws stand beside
        that.
        """
        total: dict[str, float] = dict.fromkeys(COMPONENTS, 0.0)
        for s in self.scored:
            if s.explanation == UNKNOWN:
                for explanation, share in self.behind.get(UNKNOWN, {}).items():
                    _, (curve,) = split(explanation)
                    total[component_of(curve)] += share * s.probability
            else:
                for component in {component_of(name) for name in s.explanation}:
                    total[component] += s.probability
        return total


def log_prior(explanation: Explanation) -> float:
    """Log probability of an explanation before any data, up to a constant."""
    laws, curves = split(explanation)
    return -math.log(math.comb(len(library()), len(laws)) * math.comb(len(COMPONENTS), len(curves)))


def log_posterior(marginals: Sequence[Marginal]) -> np.ndarray:
    """Log probability (n,) of each explanation beside its discrepancy, of which none is preferred.

    In a data set drawn anew a condition counts as often as it is drawn, beside what fitted all.
    """
    log_p = np.array([m.log_z + log_prior(m.explanation) for m in marginals])
    of = np.array([m.of_conditions or (0.0,) for m in marginals])
    conditions = of.shape[1]
    even = np.full(conditions, 1 / conditions)
    more = np.random.default_rng(0).multinomial(conditions, even, DATA_SETS) - 1
    drawn = log_p + more @ of.T
    return np.asarray(logsumexp(log_softmax(drawn, axis=1), axis=0) - np.log(DATA_SETS))


def posterior(marginals: Sequence[Marginal]) -> Posterior:
    """The probability of every explanation, whatever the discrepancy."""
    log_p = log_posterior(marginals)
    p = np.exp(log_p)
    # small laws that data need where forms may be wrong, and what is likely whatever the forms are
    sure, likely = laws_in(CREDIBLE, marginals, log_p, FORMS), laws_in(POSITIVE, marginals, log_p)
    told = {m.explanation: _as_stated(m, sure) for m in marginals}
    answers = [
        told[m.explanation] if m.discrepancy <= FORMS or not likely.isdisjoint(m.explanation) else UNKNOWN
        for m in marginals
    ]
    beside: dict[Explanation, dict[float, float]] = {}
    for m, value, answer in zip(marginals, p.tolist(), answers, strict=True):
        sizes = beside.setdefault(answer, {})
        sizes[m.discrepancy] = sizes.get(m.discrepancy, TINY) + value
    total = {e: sum(sizes.values()) for e, sizes in beside.items()}
    return Posterior(
        ranked(total),
        _behind(marginals, log_p, told, answers),
        {e: {size: value / total[e] for size, value in sizes.items()} for e, sizes in beside.items()},
    )


def _as_stated(m: Marginal, sure: set[str]) -> Explanation:
    """How an explanation is stated: a free curve, alone or beside laws, as an unknown cause."""
    if is_free_curve(m.explanation):
        return UNKNOWN
    small = minor(m) - sure
    return tuple(name for name in m.explanation if name not in small)


def laws_in(
    enough: float, marginals: Sequence[Marginal], log_p: np.ndarray, size: float | None = None
) -> set[str]:
    """The laws that at least a share of the probability of no law and of laws has, beside one `size` or all."""
    by_laws = [
        k
        for k, m in enumerate(marginals)
        if not is_free_curve(m.explanation) and size in (None, m.discrepancy)
    ]
    if not by_laws:
        return set()
    shares = of_laws([marginals[k].explanation for k in by_laws], softmax(log_p[by_laws]).tolist())
    return {name for name, share in shares.items() if share >= enough}


def of_laws(explanations: Iterable[Iterable[str]], probability: Iterable[float]) -> dict[str, float]:
    """Of each law the probability of the explanations that have it."""
    total: dict[str, float] = {}
    for explanation, p in zip(explanations, probability, strict=True):
        for name in explanation:
            total[name] = total.get(name, 0.0) + p
    return total


def minor(m: Marginal) -> set[str]:
    """The laws of an explanation that are small: all but the largest that hold 95 % of the laws' mean squares."""
    squares = np.square(m.changes)
    order = np.argsort(-squares, kind="stable")
    before = np.cumsum(squares[order]) - squares[order]
    enough = CREDIBLE * squares.sum()
    return {m.explanation[k] for k, larger in zip(order, before, strict=True) if 0 < enough <= larger}


def _behind(
    marginals: Sequence[Marginal],
    log_p: np.ndarray,
    told: dict[Explanation, Explanation],
    answers: Sequence[Explanation],
) -> dict[Explanation, dict[Explanation, float]]:
    """The shares of what is stated alike, also where something else is more probable by any factor.

    What laws have as an unknown cause is no share of it: that is told by free curves.
    """
    log_shares: dict[Explanation, dict[Explanation, float]] = {}
    for m, value, answer in zip(marginals, log_p.tolist(), answers, strict=True):
        if answer == told[m.explanation]:
            of = log_shares.setdefault(answer, {})
            of[m.explanation] = float(np.logaddexp(of.get(m.explanation, -np.inf), value))
    return {
        stated: dict(zip(of, np.maximum(softmax(list(of.values())), TINY).tolist(), strict=True))
        for stated, of in log_shares.items()
    }


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

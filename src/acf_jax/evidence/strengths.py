"""What the strengths of effects are worth: which of them act, with which sign, and how large they are.

A strength has no scale of its own: what acts of an effect is as likely to be of any size, on a logarithmic scale, from
what can just be told to the largest. The average over sizes is taken in closed form. Of several strengths any may act,
alone or with others, and with either sign where both make sense: all these ways are as likely. The evidence of an
effect is its mean over them. Those that count are found from the fit, by taking strengths out one after the other.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.special import gammaln, logsumexp

from acf_jax.inference.fit import Fit
from acf_jax.inference.parameters import RIG, Explanation, every_effect

SIZES = np.geomspace(2.0, 600.0, 200)  # whitened distances that an effect is as likely to have


class Weighed(NamedTuple):
    """The evidence of some ways in which the strengths of a fit may act, and the curvature in all else."""

    ways: dict[tuple[int, ...], float]  # log evidence by which parameters are the strengths that act
    others: np.ndarray  # (q, q)


def weigh(fitted: Fit) -> Weighed:
    """The way of a fit, and those with fewer strengths: one after the other is taken out as long as that gains.

    The log evidence of each is that over the one of all else, which is integrated out, to second order about the fit.
    """
    known, others = _known(fitted)
    acts = known.is_strength & (known.u != 0)
    tried = {tuple(known.at[acts].tolist()): known.log_evidence(acts)}
    while True:
        best = max(tried.values())
        removable = [k for k in np.flatnonzero(acts) if acts[known.of == known.of[k]].sum() > 1]
        fewer = [acts & (np.arange(len(acts)) != k) for k in removable]
        found = [known.log_evidence(each) for each in fewer]
        tried |= {tuple(known.at[each].tolist()): z for each, z in zip(fewer, found, strict=True)}
        if not found or max(found) <= best:
            return Weighed(tried, others)
        acts = fewer[int(np.argmax(found))]


def log_mean(weighed: Weighed, explanation: Explanation) -> float:
    """Log evidence of an explanation: the mean over all its ways; those that were not weighed add nothing."""
    return float(logsumexp(list(weighed.ways.values())) - math.log(math.prod(map(ways, explanation))))


def ways(name: str) -> int:
    """In how many ways an effect may act: each strength not at all, or with each sign that it may have."""
    each = (3 if p.low < 0 else 2 for p in every_effect()[name].parameters() if p.is_size)
    return math.prod(each) - 1


class _Known(NamedTuple):
    """Strengths, and what says nothing unless some of these act; all else is integrated out."""

    at: np.ndarray  # (k,) int, where each stands among the parameters
    u: np.ndarray  # (k,) in units of the priors
    curvature: np.ndarray  # (k, k)
    of: np.ndarray  # (k,) int, of which effect each is
    needs: np.ndarray  # (k, k) bool, the strengths of which one has to act for it to say anything
    is_strength: np.ndarray  # (k,) bool
    is_positive: np.ndarray  # (k,) bool, strengths that have one sign

    def log_evidence(self, acts: np.ndarray) -> float:
        """That of the strengths that act, (k,) bool, over that of all at the fit under standard normal priors."""
        alive = (self.needs & acts).any(1)
        absent, idle = self.is_strength & ~acts, ~self.is_strength & ~alive
        kept, across = self.curvature[np.ix_(alive, alive)], self.curvature[np.ix_(alive, absent)]
        left_out = self.u[absent]
        moved = np.linalg.solve(kept, across) @ left_out
        u, variance = self.u.copy(), np.zeros_like(self.curvature)
        u[alive] += moved
        if (u[acts & self.is_positive] < 0).any():
            return -np.inf
        variance[np.ix_(alive, alive)] = np.linalg.inv(kept)
        each = (acts & (self.of == k) for k in np.unique(self.of))
        sizes = sum(of_size(u[chosen], variance[np.ix_(chosen, chosen)]) for chosen in each)
        misfit = left_out @ (self.curvature[np.ix_(absent, absent)] @ left_out - across.T @ moved)
        prior_of_idle = self.u[idle] @ self.u[idle]
        return float(sizes - 0.5 * (misfit - prior_of_idle + np.linalg.slogdet(kept)[1]))


def _known(fitted: Fit) -> tuple[_Known, np.ndarray]:
    """The strengths of a fit and what needs them, and the curvature in all else."""
    names = [(k, p) for k, name in enumerate(fitted.explanation) for p in every_effect()[name].parameters()]
    chosen = [(at, k, p) for at, (k, p) in enumerate(names, len(RIG)) if p.is_size or p.needs]
    at, of = (np.array([row[column] for row in chosen], int) for column in (0, 1))
    needs = [
        [k == of_it and p.name in (it.needs or (it.name,)) for _, k, p in chosen] for _, of_it, it in chosen
    ]
    rest = np.setdiff1d(np.arange(len(fitted.u)), at)
    h = fitted.hessian
    others, across = h[np.ix_(rest, rest)], h[np.ix_(rest, at)]
    known = _Known(
        at,
        fitted.u[at],
        h[np.ix_(at, at)] - across.T @ np.linalg.solve(others, across),
        of,
        np.array(needs, bool).reshape(len(at), len(at)),
        np.array([p.is_size for *_, p in chosen], bool),
        np.array([p.is_size and p.low >= 0 for *_, p in chosen], bool),
    )
    return known, others


def of_size(u: np.ndarray, variance: np.ndarray) -> float:
    """What the prior of acting strengths u (k,) is worth in place of a standard normal one, in log.

    Their sum r is log-uniform, their shares of it are uniform. `variance`: (k, k) of the strengths.
    """
    k, total = len(u), float(np.abs(u).sum())
    if not k:
        return float(logsumexp(-0.5 * SIZES**2) - np.log(len(SIZES)))  # it is not there
    sign = np.where(u < 0, -1.0, 1.0)
    std = max(float(np.sqrt(sign @ variance @ sign)), total / SIZES[-1])
    size = logsumexp(-0.5 * (total / std - SIZES) ** 2 - (k - 1) * np.log(SIZES)) - np.log(len(SIZES))
    shares = (k - 1) * 0.5 * np.log(2 * np.pi) + gammaln(k)
    return float(size + shares - k * np.log(std) + 0.5 * (u**2).sum())

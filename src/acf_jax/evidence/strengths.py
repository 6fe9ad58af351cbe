"""What the strengths of effects are worth: which of them act, and how large they are, averaged over.

A strength has no scale of its own: an effect is as likely to be of any size, on a logarithmic scale, from what can just
be told to the largest. The average over sizes is taken in closed form. Of several strengths any may act alone or with
others, and each such choice is as likely.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import gammaln, logsumexp

from acf_jax.effects import Parameter
from acf_jax.inference.fit import Fit
from acf_jax.inference.parameters import RIG, every_effect

SIZES = np.geomspace(2.0, 600.0, 200)  # whitened distances that an effect is as likely to have


def strengths(fitted: Fit) -> tuple[float, np.ndarray]:
    """Log evidence of the strengths of a fit over that of all else, which is integrated out; the curvature of that.

    It is that of the choice of strengths that is most probable, to second order about the fit: from all that act,
    one after the other is taken out as long as that gains.
    """
    known, others = _known(fitted)
    acts = known.is_strength & (known.u != 0)
    best = known.log_evidence(acts)
    while True:
        alone = [k for k in np.flatnonzero(acts) if acts[known.of == known.of[k]].sum() > 1]
        fewer = [acts & (np.arange(len(acts)) != k) for k in alone]
        found = [known.log_evidence(each) for each in fewer]
        if not found or max(found) <= best:
            return best, others
        best, acts = max(found), fewer[int(np.argmax(found))]


class _Known(NamedTuple):
    """Strengths, and shapes that say nothing unless some of these act; all else is integrated out."""

    u: np.ndarray  # (k,) in units of the priors
    curvature: np.ndarray  # (k, k)
    of: np.ndarray  # (k,) int, of which effect each is
    needs: np.ndarray  # (k, k) bool, the strengths of which a shape needs one
    is_strength: np.ndarray  # (k,) bool

    def log_evidence(self, acts: np.ndarray) -> float:
        """Where of the strengths these act, (k,) bool, against standard normal priors of all, at the fit."""
        alive = acts | (self.needs & acts).any(1)
        absent, idle = self.is_strength & ~acts, ~self.is_strength & ~alive
        kept, across = self.curvature[np.ix_(alive, alive)], self.curvature[np.ix_(alive, absent)]
        left_out = self.u[absent]
        moved = np.linalg.solve(kept, across) @ left_out
        misfit = left_out @ (self.curvature[np.ix_(absent, absent)] @ left_out - across.T @ moved)
        u, variance = self.u.copy(), np.zeros_like(self.curvature)
        u[alive] += moved
        variance[np.ix_(alive, alive)] = np.linalg.inv(kept)
        each = (acts & (self.of == k) for k in np.unique(self.of))
        sizes = sum(of_size(u[own], variance[np.ix_(own, own)]) for own in each)
        spared = misfit - self.u[idle] @ self.u[idle]
        return float(sizes - 0.5 * (spared + np.linalg.slogdet(kept)[1]))


def _known(fitted: Fit) -> tuple[_Known, np.ndarray]:
    """The strengths of a fit and their shapes, and the curvature in all else."""
    names = [(k, p) for k, name in enumerate(fitted.explanation) for p in every_effect()[name].parameters()]
    chosen = [(at, k, p) for at, (k, p) in enumerate(names, len(RIG)) if _is_strength(p) or p.needs]
    at, of = (np.array([row[column] for row in chosen], int) for column in (0, 1))
    needs = [[p.name in shape.needs and k == own for _, k, p in chosen] for _, own, shape in chosen]
    is_strength = np.array([_is_strength(p) for *_, p in chosen], bool)
    rest = np.setdiff1d(np.arange(len(fitted.u)), at)
    h = fitted.hessian
    others, across = h[np.ix_(rest, rest)], h[np.ix_(rest, at)]
    known = _Known(
        fitted.u[at],
        h[np.ix_(at, at)] - across.T @ np.linalg.solve(others, across),
        of,
        np.array(needs, bool).reshape(len(at), len(at)),
        is_strength,
    )
    return known, others


def ways(name: str) -> int:
    """In how many ways an effect may act: a choice of its strengths each, and the sign of one that may have either."""
    effect = every_effect()[name]
    return (2 ** sum(map(_is_strength, effect.parameters())) - 1) * (2 if effect.acts_either_way() else 1)


def _is_strength(p: Parameter) -> bool:
    return not (p.shape or p.within)


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

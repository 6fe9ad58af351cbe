"""What each effect would change about the forces of a fitted rig, and how much of the gap it promises to explain."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from acf_jax.inference.fit import Fit
from acf_jax.inference.linear import is_bounded, residuals
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import (
    RIG,
    Explanation,
    every_effect,
    looks,
    parameters,
    places,
    starts,
    switched_off,
)
from acf_jax.inference.projection import Projector


class Promise(NamedTuple):
    """What an effect may explain of what a fit leaves, to first order."""

    gain: float  # in chi-square
    parameters: np.ndarray  # from which a fit with it may begin
    start: list[float]  # the start of the effect of which this is told


@dataclass(frozen=True)
class Ground:
    """A fit, beside which effects are tried one by one."""

    observations: Observations
    fitted: Fit
    projector: Projector  # what the fit's own parameters could imitate
    bare: np.ndarray  # (trials, n) of `residuals`, of the fit
    known: dict[tuple[str, tuple[float, ...]], np.ndarray]  # signatures of effects with their starts
    instead_of: str | None = None  # the law of the fit in whose place effects are tried

    @classmethod
    def of(cls, observations: Observations, fitted: Fit) -> "Ground":
        """The ground of a fit."""
        (bare,) = _residuals(observations, fitted, fitted.explanation, fitted.theta[None])
        return cls(observations, fitted, Projector.of(fitted), bare, {})

    def without(self, law: str) -> "Ground":
        """The same with a law taken out, all else as it is: that is nearer to a fit with a law like it than what is
        fitted again without it."""
        fitted = self.fitted
        theta = switched_off(fitted.explanation, fitted.theta, [law])
        (residual,) = _residuals(self.observations, fitted, fitted.explanation, theta[None])
        taken = places((law,), fitted.explanation)[len(RIG) :]
        projector = self.projector.without(fitted, taken, residual - self.bare)
        return replace(self, projector=projector, instead_of=law)

    def sought(self, strength: str, shape: str, looks: int) -> Promise:
        """What a strength of the fit's own, in place of what it is, would gain at the best value of its shape.

        `strength`, `shape`: full names; `looks`: at how many values of the shape. Parameters are those of the fit.
        """
        known = dict(parameters(self.fitted.explanation))
        taken = np.array([list(known).index(strength), list(known).index(shape)])
        theta = np.tile(self.fitted.theta, (looks + 1, 1))
        theta[:, taken[0]] = known[strength].scale
        theta[1:, taken[1]] = np.geomspace(known[shape].low, known[shape].high, looks)
        theta[0, taken[0]] = 0.0
        less, *more = _residuals(self.observations, self.fitted, self.fitted.explanation, theta)
        projector = self.projector.without(self.fitted, taken, less - self.bare)
        now = 2 * (projector.left - self.fitted.objective)  # what the fit gains by it
        found = [Promise(0.0, self.fitted.theta, [])]
        for signal, begin in zip(less - np.array(more), theta[1:], strict=True):
            amount, gain = projector.promise(signal)
            if amount > 0:
                begin[taken[0]] = min(amount * known[strength].scale, known[strength].high)
                found.append(Promise(gain - now, begin, []))
        return max(found, key=lambda promise: promise.gain)

    def signatures(
        self, name: str, begins: Sequence[list[float]]
    ) -> Iterator[tuple[list[float], np.ndarray]]:
        """Of each start the whitened change of the prediction."""
        keys = [(name, tuple(start)) for start in begins]
        if new := [key for key in keys if key not in self.known]:
            theta = with_one_more(self.fitted, name, [start for _, start in new])
            explanation = one_more(self.fitted.explanation, name)
            found = _residuals(self.observations, self.fitted, explanation, theta)
            self.known.update(zip(new, self.bare - found, strict=True))
        for start, key in zip(begins, keys, strict=True):
            if is_bounded(self.known[key]):
                yield start, self.known[key]

    def promise(self, name: str) -> Promise:
        """The best of `promises`."""
        return self.promises(name)[0]

    def promises(self, name: str) -> list[Promise]:
        """How much of what is left an effect explains, over its starts and where else fits look, the best first.

        To first order: a signature s takes (r' P s)^2 / s' P s of the residual r, with a sign that the effect allows.
        Its strengths are scaled to that. A mass on a spring, scaled, would ring at another frequency: where strengths
        are looked over, they begin as they are. Besides the best, those that promise more than the looks on either
        side: each may lead to another valley of the misfit.
        """
        known, measures = every_effect()[name].parameters(), self.observations.measures
        strengths = np.array([not p.shape for p in known])
        two_sided = every_effect()[name].acts_either_way()
        is_oscillator = any(p.looks and not p.shape for p in known)
        begins, looked = starts(name, measures), looks(name, measures)
        found = {tuple(start): Promise(0.0, np.array(start), start) for start in (*begins, *looked)}
        for start, signal in self.signatures(name, [*begins, *looked]):
            amount, gain = self.projector.promise(signal)
            if two_sided or is_oscillator or amount > 0:
                scale = 1.0 if is_oscillator else amount
                found[tuple(start)] = Promise(gain, np.where(strengths, scale, 1.0) * np.array(start), start)
        best = max(found.values(), key=lambda p: p.gain)
        over = [found[tuple(start)] for start in looked]
        gains = [-np.inf, *(p.gain for p in over), -np.inf]
        crests = [p for k, p in enumerate(over) if gains[k] < p.gain >= gains[k + 2] and p is not best]
        return [best, *sorted(crests, key=lambda p: -p.gain)]


def one_more(explanation: Explanation, name: str, instead_of: str | None = None) -> Explanation:
    """An explanation with one more effect, in place of a law or besides all."""
    return tuple(sorted((*(law for law in explanation if law != instead_of), name)))


def with_one_more(
    fitted: Fit, name: str, begins: Sequence[Sequence[float] | np.ndarray], instead_of: str | None = None
) -> np.ndarray:
    """Parameters (k, p) of a fit with one more effect, with each of its values, in place of a law or besides all."""
    explanation = one_more(fitted.explanation, name, instead_of)
    rest = tuple(law for law in explanation if law != name)
    physical = np.empty((len(begins), len(parameters(explanation))))
    physical[:, places(rest, explanation)] = fitted.physical[places(rest, fitted.explanation)]
    physical[:, places((name,), explanation)[len(RIG) :]] = begins
    return np.hstack([physical, np.tile(fitted.common, (len(begins), 1))])


def _residuals(
    observations: Observations, fitted: Fit, explanation: Explanation, theta: np.ndarray
) -> np.ndarray:
    """(k, trials, n) whitened residuals of parameters (k, p), with the nuisances of a fit."""
    return residuals(observations, explanation, theta, fitted.nuisance, fitted.grid)

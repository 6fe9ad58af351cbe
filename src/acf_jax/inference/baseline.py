"""What each effect would change about the forces of a fitted rig, and how much of the gap it promises to explain."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from acf_jax.inference.fit import Fit
from acf_jax.inference.linear import is_bounded, residual
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import RIG, Explanation, every_effect, looks, starts
from acf_jax.inference.projection import Projector


class Promise(NamedTuple):
    """What an effect may explain of what a fit leaves, to first order."""

    gain: float  # in chi-square
    parameters: np.ndarray  # from which a fit with it may begin
    start: list[float]  # the start of the effect of which this is told


@dataclass(frozen=True)
class Ground:
    """A fitted rig without any effect, on which effects are tried one by one."""

    observations: Observations
    rig: Fit  # whose rig and nuisances are kept, and whose effects are left out
    fitted: Fit  # what effects would be added to: the same fit, or one with other effects beside the same rig
    projector: Projector  # what the fit's own parameters could imitate
    bare: np.ndarray  # (trials, n) whitened residual without any effect
    known: dict[tuple[str, tuple[float, ...]], np.ndarray]  # signatures of effects with their starts

    @classmethod
    def of(cls, observations: Observations, fitted: Fit) -> "Ground":
        """The rig of a fit."""
        bare = _residual(observations, fitted, (), [])
        return cls(observations, fitted, fitted, Projector.of(fitted), bare, {})

    def beside(self, fitted: Fit) -> "Ground":
        """The same rig under a fit that has other effects and the same rig and nuisances."""
        return replace(self, fitted=fitted, projector=Projector.of(fitted))

    def signatures(
        self, name: str, begins: Sequence[list[float]]
    ) -> Iterator[tuple[list[float], np.ndarray]]:
        """Of each start the whitened change of the prediction."""
        for start in begins:
            key = name, tuple(start)
            if key not in self.known:
                self.known[key] = self.bare - _residual(self.observations, self.rig, (name,), start)
            if is_bounded(self.known[key]):
                yield start, self.known[key]

    def promise(self, name: str) -> Promise:
        """The best of `promises`."""
        return self.promises(name)[0]

    def promises(self, name: str) -> list[Promise]:
        """How much of what the fit leaves an effect explains, over its starts and where else fits look, the best first.

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


def _residual(
    observations: Observations, fitted: Fit, explanation: Explanation, start: list[float]
) -> np.ndarray:
    """(trials, n) whitened measured minus predicted with an effect on the fitted rig."""
    theta = np.concatenate([fitted.theta[: len(RIG)], start, fitted.common])
    return residual(observations, explanation, theta, fitted.nuisance, fitted.grid._replace(program=None))

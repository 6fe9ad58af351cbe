"""A viscoelastic pad: one or two Maxwell branches beside a spring.

Source: generalised Maxwell (Wiechert) model, Christensen, Theory of Viscoelasticity (1982), ch. 1.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractContactCause, Motion, State, Value, positive


@dataclass(frozen=True)
class PadRelaxation(AbstractContactCause):
    """F = k_C (s - sum a_i z_i), z_i' = (s - z_i)/tau_i; z_i(0) = s_0 if the preload has relaxed, else 0."""

    shares: tuple[float, ...]  # a_i
    times: tuple[float, ...]  # tau_i, s
    relaxed: bool  # whether the pad had rested under its preload

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        two_branches, relaxed = rng.random() < 0.4, bool(rng.random() < 0.6)
        time = rig.half_period * np.exp(rng.uniform(np.log(0.08), np.log(0.5)))
        split, ratio = rng.uniform(0.4, 0.6), rng.uniform(3.0, 6.0)
        share = 0.5 * size
        if two_branches:
            return cls((share * split, share * (1.0 - split)), (time, time * ratio), relaxed)
        return cls((share,), (time,), relaxed)

    def initial(self, rig: Rig, s: float, force: float) -> tuple[float, ...]:
        return tuple(s * self.relaxed for _ in self.times)

    def rates(self, z: State, rig: Rig, impact: Impact, now: Motion) -> tuple[float, ...]:
        return tuple((now.s - z_i) / tau for z_i, tau in zip(z, self.times, strict=True))

    def contact(self, force: Value, z: State, rig: Rig, impact: Impact, s: Value, s_rate: Value) -> Value:
        relaxed = sum(a * z_i for a, z_i in zip(self.shares, z, strict=True))
        return positive(force - rig.k_c * relaxed)

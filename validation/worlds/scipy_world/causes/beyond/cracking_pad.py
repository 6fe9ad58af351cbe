"""The pad cracks: past a compression it loses a share of its stiffness, in each impact anew and for good.

Source: scalar damage, Lemaitre, A Course on Damage Mechanics (1996), ch. 1.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractContactCause, Motion, State, Value, positive


@dataclass(frozen=True)
class CrackingPad(AbstractContactCause):
    """F = k_C s (1 - D), D' = (share - D) max(0, s - s_c)/(s_c t_c)."""

    share: float
    compression: float  # s_c, m
    time: float  # t_c, s

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        force = rng.uniform(110.0, 160.0)
        return cls(min(0.5 * size, 0.8), force / rig.k_c, 0.05 * rig.half_period)

    def initial(self, rig: Rig, s: float, force: float) -> tuple[float, ...]:
        return (0.0,)

    def rates(self, z: State, rig: Rig, impact: Impact, now: Motion) -> tuple[float, ...]:
        overload = float(positive(now.s - self.compression)) / self.compression
        return ((self.share - z[0]) * overload / self.time,)

    def contact(self, force: Value, z: State, rig: Rig, impact: Impact, s: Value, s_rate: Value) -> Value:
        return force * (1.0 - z[0])

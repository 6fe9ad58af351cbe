"""The pad yields: above a force it flows, and what has flowed does not come back.

Source: Perzyna overstress, Lemaitre and Chaboche, Mechanics of Solid Materials (1990), ch. 6.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractContactCause, Motion, State, Value, positive


@dataclass(frozen=True)
class YieldingPad(AbstractContactCause):
    """F = k_C max(0, s - q), q' = max(0, F - F_y)/(k_C t_y)."""

    yield_force: float  # F_y, N
    time: float  # t_y, s

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        return cls(rng.uniform(110.0, 150.0), rng.uniform(0.1, 0.2) * rig.half_period / max(size, 1e-9))

    def initial(self, rig: Rig, s: float, force: float) -> tuple[float, ...]:
        return (0.0,)

    def rates(self, z: State, rig: Rig, impact: Impact, now: Motion) -> tuple[float, ...]:
        return (float(positive(now.f_c - self.yield_force)) / (rig.k_c * self.time),)

    def contact(self, force: Value, z: State, rig: Rig, impact: Impact, s: Value, s_rate: Value) -> Value:
        return positive(force - rig.k_c * z[0])

"""The flange meets a rubber buffer part of the way along its stroke."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractActuatorCause, Motion, State


@dataclass(frozen=True)
class BumpStop(AbstractActuatorCause):
    """F = k_b max(0, x - gap)."""

    gap: float  # m
    stiffness: float  # N/m

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        stroke = 0.25 * rig.half_period
        return cls(rng.uniform(0.1, 0.35) * stroke, rig.k_c * rng.uniform(0.05, 0.2) * size)

    def opposing(self, z: State, rig: Rig, impact: Impact, now: Motion) -> float:
        return self.stiffness * max(0.0, now.x - self.gap)

"""Weight of the moving mass along the stroke of a flange mounted at an inclination."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractActuatorCause, Motion, State


@dataclass(frozen=True)
class Gravity(AbstractActuatorCause):
    """F = m g sin(inclination), either sign; `size` 1 is up to upright."""

    inclination: float  # rad, positive where the weight opposes compression

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        sign = rng.choice([-1.0, 1.0])
        return cls(inclination=float(sign * np.arcsin(min(size, 1.0) * rng.uniform(0.7, 1.0))))

    def opposing(self, z: State, rig: Rig, impact: Impact, now: Motion) -> float:
        return rig.m * 9.81 * float(np.sin(self.inclination))

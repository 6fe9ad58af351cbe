"""A magnet or spring-ball detent holds the flange near its rest position and lets go along the stroke."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractActuatorCause, Motion, State


@dataclass(frozen=True)
class MagneticDetent(AbstractActuatorCause):
    """F = F_d (x/g) e^{1/2 - (x/g)^2/2}: largest at x = g, gone a few g later."""

    force_n: float
    gap: float  # g, m

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        stroke = 0.2 * rig.half_period
        return cls(150.0 * size, rng.uniform(0.03, 0.1) * stroke)

    def opposing(self, z: State, rig: Rig, impact: Impact, now: Motion) -> float:
        relative = now.x / self.gap
        return float(self.force_n * relative * np.exp(0.5 - 0.5 * relative**2))

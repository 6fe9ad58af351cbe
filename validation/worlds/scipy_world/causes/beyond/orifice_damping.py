"""Air is forced through an orifice: a resistance that grows with the square of the velocity.

Source: Andersen, The Analysis and Design of Pneumatic Systems (1967), ch. 2 (incompressible limit).
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractActuatorCause, Motion, State


@dataclass(frozen=True)
class OrificeDamping(AbstractActuatorCause):
    """F = c x'^2 while the flange is compressed, a tenth of it on the way back (check valve)."""

    quadratic: float  # c, N s^2/m^2

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        return cls(rng.uniform(0.3, 0.7) * size * rig.impedance / 0.3)

    def opposing(self, z: State, rig: Rig, impact: Impact, now: Motion) -> float:
        return self.quadratic * now.x_rate**2 * (1.0 if now.x_rate > 0.0 else -0.1)

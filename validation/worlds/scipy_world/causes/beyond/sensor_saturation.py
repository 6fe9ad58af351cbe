"""The amplifier saturates softly: large forces read too low."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Array, Rig
from validation.worlds.scipy_world.hooks import AbstractSensorCause


@dataclass(frozen=True)
class SensorSaturation(AbstractSensorCause):
    """reading = F/(1 + (F/F_s)^p)^(1/p)."""

    limit: float  # F_s, N
    sharpness: float  # p

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        return cls(0.25 * rig.impedance / max(size, 1e-9) ** 0.5, rng.uniform(3.0, 8.0))

    def read(self, time: Array, force: Array) -> Array:
        relative = np.maximum(force, 0.0) / self.limit
        return force / (1.0 + relative**self.sharpness) ** (1.0 / self.sharpness)

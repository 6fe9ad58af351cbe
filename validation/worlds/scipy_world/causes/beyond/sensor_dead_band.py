"""The sensor's mounting has play: small forces take another way past it, so all readings lose a part."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Array, Rig
from validation.worlds.scipy_world.hooks import AbstractSensorCause


@dataclass(frozen=True)
class SensorDeadBand(AbstractSensorCause):
    """reading = max(0, F - F_0 (1 - e^{-F/F_0}))."""

    band: float  # F_0, N

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        return cls(rng.uniform(30.0, 60.0) * size)

    def read(self, time: Array, force: Array) -> Array:
        return force - self.band * (1.0 - np.exp(-np.maximum(force, 0.0) / self.band))

"""Gain error of the force measurement."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Array, Rig
from validation.worlds.scipy_world.hooks import AbstractSensorCause


@dataclass(frozen=True)
class SensorScale(AbstractSensorCause):
    """reading = gain F, 20 % off at `size` 1."""

    gain: float

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        return cls(float(1.0 + rng.choice([-1.0, 1.0]) * 0.2 * size))

    def read(self, time: Array, force: Array) -> Array:
        return self.gain * force

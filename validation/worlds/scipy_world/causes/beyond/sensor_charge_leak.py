"""A piezoelectric sensor whose charge leaks away: a high-pass that pulls long forces down.

Source: charge amplifier with time constant R C, Gautschi, Piezoelectric Sensorics (2002), ch. 11.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.filters import low_pass
from validation.worlds.interface import Array, Rig
from validation.worlds.scipy_world.hooks import AbstractSensorCause


@dataclass(frozen=True)
class SensorChargeLeak(AbstractSensorCause):
    """reading = tau s/(1 + tau s) F."""

    time: float  # tau, s

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        return cls(rig.half_period * rng.uniform(1.5, 3.0) / max(size, 1e-9))

    def read(self, time: Array, force: Array) -> Array:
        return force - low_pass(time, force, [1.0], [self.time, 1.0])

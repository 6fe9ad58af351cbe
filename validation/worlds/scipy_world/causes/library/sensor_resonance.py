"""A lightly damped mode of sensor and mounting; the rest of the force passes rigidly.

Source: modal superposition, Ewins, Modal Testing (2000), ch. 2. A real flange's mounting rings at 470 to
625 Hz.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.filters import low_pass
from validation.worlds.interface import Array, Rig
from validation.worlds.scipy_world.hooks import AbstractSensorCause


@dataclass(frozen=True)
class SensorResonance(AbstractSensorCause):
    """reading = (1 - share) F + share y, y'' + 2 ratio w y' + w^2 y = w^2 F."""

    frequency: float  # w/2 pi, Hz
    damping_ratio: float
    share: float  # participation of the mode

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        frequency = rng.uniform(5.0, 14.0) * rig.omega / (2.0 * np.pi)
        return cls(frequency, rng.uniform(0.01, 0.08), min(size, 1.0))

    def read(self, time: Array, force: Array) -> Array:
        omega = 2.0 * np.pi * self.frequency
        mode = low_pass(time, force, [1.0], [omega**-2, 2.0 * self.damping_ratio / omega, 1.0])
        return (1.0 - self.share) * force + self.share * mode

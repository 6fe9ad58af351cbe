"""A plate on the sensor: it rings there, and the sensor reads what the plate's spring and damper carry.

Source: Maranzano and Hancock (2016). A steel profile on a force-torque sensor rings at about 560 Hz.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.filters import low_pass
from validation.worlds.interface import Array, Rig
from validation.worlds.scipy_world.hooks import AbstractSensorCause


@dataclass(frozen=True)
class FixtureMass(AbstractSensorCause):
    """m_w w'' = F - k_w w - d_w w', reading k_w w + d_w w'; `size` is the mass, the sensor stays as it is."""

    mass: float  # m_w, kg
    stiffness: float  # k_w, N/m
    damping: float  # d_w, N s/m

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        heaviest = rng.uniform(0.5, 5.0)
        stiffness = heaviest * (rng.uniform(5.0, 14.0) * rig.omega) ** 2
        damping = 2.0 * rng.uniform(0.01, 0.08) * np.sqrt(stiffness * heaviest)
        return cls(float(heaviest * size), float(stiffness), float(damping))

    def read(self, time: Array, force: Array) -> Array:
        return low_pass(
            time, force, [self.damping, self.stiffness], [self.mass, self.damping, self.stiffness]
        )

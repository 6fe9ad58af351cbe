"""The robot's path ripples: gear meshing and servo oscillation, in no fixed phase with the contact.

Source: torque ripple of strain-wave gears, Taghirad and Belanger, J. Dyn. Syst. Meas. Control 120 (1998) 350.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractRobotCause, State, Value


@dataclass(frozen=True)
class RobotOscillation(AbstractRobotCause):
    """u = A (sin(w t + phase) - sin(phase))."""

    amplitude: float  # m
    frequency: float  # w/2 pi, Hz
    phase: float  # rad

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        frequency = rng.uniform(1.2, 3.0) / rig.half_period
        return cls(50.0 * size / rig.k_c, frequency, rng.uniform(0.0, 2.0 * np.pi))

    def offset(self, t: Value, z: State, rig: Rig, impact: Impact) -> tuple[Value, Value]:
        w = 2.0 * np.pi * self.frequency
        angle = w * t + self.phase
        return self.amplitude * (np.sin(angle) - np.sin(self.phase)), self.amplitude * w * np.cos(angle)

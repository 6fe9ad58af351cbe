"""The robot yields: a mass behind the contact that joints and servo hold like a spring and a damper.

Source: reflected mass and joint stiffness in impacts, Haddadin et al., Int. J. Robotics Research 28 (2009)
1507.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractRobotCause, Motion, State, Value


@dataclass(frozen=True)
class RobotCompliance(AbstractRobotCause):
    """M u'' + c u' + k u = -F_C, u the robot's lead on its path v t."""

    mass: float  # kg
    stiffness: float  # N/m
    damping: float  # N s/m

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        size = max(size, 1e-9)
        mass = rig.m * rng.uniform(1.0, 4.0) / size
        stiffness = rig.k_c * rng.uniform(0.4, 1.5) / size
        ratio = rng.uniform(0.02, 0.3)
        return cls(mass, stiffness, float(2.0 * ratio * np.sqrt(stiffness * mass)))

    def initial(self, rig: Rig, s: float, force: float) -> tuple[float, ...]:
        return (0.0, 0.0)

    def rates(self, z: State, rig: Rig, impact: Impact, now: Motion) -> tuple[float, ...]:
        return (z[1], -(now.f_c + self.damping * z[1] + self.stiffness * z[0]) / self.mass)

    def offset(self, t: Value, z: State, rig: Rig, impact: Impact) -> tuple[Value, Value]:
        return z[0], z[1]

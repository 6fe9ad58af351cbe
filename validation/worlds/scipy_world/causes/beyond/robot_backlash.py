"""Play in the robot's gears: its link falls back freely across the gap before the drive holds it.

Source: dead-zone model, Nordin and Gutman, Automatica 38 (2002) 1633.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractRobotCause, Motion, State, Value


@dataclass(frozen=True)
class RobotBacklash(AbstractRobotCause):
    """M u'' + c u' + k (u outside -gap..0) = -F_C."""

    mass: float  # kg
    stiffness: float  # N/m
    damping: float  # N s/m
    gap: float  # m

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        mass = rig.m * rng.uniform(2.0, 4.0)
        stiffness = rig.k_c * rng.uniform(20.0, 40.0) / max(size, 1e-3)
        gap = 0.25 * size * 0.3 * rig.impedance / rig.k_c
        return cls(mass, stiffness, float(0.6 * np.sqrt(stiffness * mass)), gap)

    def initial(self, rig: Rig, s: float, force: float) -> tuple[float, ...]:
        return (0.0, 0.0)

    def rates(self, z: State, rig: Rig, impact: Impact, now: Motion) -> tuple[float, ...]:
        held = min(z[0] + self.gap, 0.0) + max(z[0], 0.0)
        damping = self.damping if held else 0.0
        return (z[1], -(now.f_c + damping * z[1] + self.stiffness * held) / self.mass)

    def offset(self, t: Value, z: State, rig: Rig, impact: Impact) -> tuple[Value, Value]:
        return z[0], z[1]

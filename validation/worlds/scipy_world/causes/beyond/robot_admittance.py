"""The robot's own force control gives way: an admittance law on a filtered force above a threshold.

Source: Hogan, J. Dyn. Syst. Meas. Control 107 (1985) 1.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractRobotCause, Motion, State, Value, positive


@dataclass(frozen=True)
class RobotAdmittance(AbstractRobotCause):
    """u' = -max(0, f - threshold)/b, f' = (F_C - f)/tau."""

    damping: float  # b, N s/m
    threshold: float  # N
    filter_time: float  # tau, s

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        damping = rig.impedance * rng.uniform(0.8, 1.6) / max(size, 1e-9)
        return cls(damping, rng.uniform(90.0, 130.0), rng.uniform(0.05, 0.2) * rig.half_period)

    def initial(self, rig: Rig, s: float, force: float) -> tuple[float, ...]:
        return (0.0, 0.0)

    def rates(self, z: State, rig: Rig, impact: Impact, now: Motion) -> tuple[float, ...]:
        return (self._velocity(z), (now.f_c - z[1]) / self.filter_time)

    def _velocity(self, z: State) -> Value:
        return -positive(z[1] - self.threshold) / self.damping

    def offset(self, t: Value, z: State, rig: Rig, impact: Impact) -> tuple[Value, Value]:
        return z[0], self._velocity(z)

"""A pad or backing plate with mass, stiffness and damping of its own between contact and flange mass."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractSeatCause, Motion, State, Value


@dataclass(frozen=True)
class PadMass(AbstractSeatCause):
    """m_p x_p'' = F_C - F_p, F_p = k_p (x_p - x) + c_p (x_p' - x') + F_C(0): the pad starts preloaded."""

    mass: float  # m_p, kg
    stiffness: float  # k_p, N/m
    damping: float  # c_p, N s/m

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        mass = 0.3 * size * rig.m
        stiffness = rig.k_c * rng.uniform(2.0, 6.0) / max(size, 1e-9) ** 0.5
        ratio = rng.uniform(0.02, 0.15)
        return cls(mass, stiffness, float(2.0 * ratio * np.sqrt(stiffness * mass)))

    def initial(self, rig: Rig, s: float, force: float) -> tuple[float, ...]:
        return (0.0, 0.0, force)  # the preload stays as it is

    def rates(self, z: State, rig: Rig, impact: Impact, now: Motion) -> tuple[float, ...]:
        return (z[1], (now.f_c - self.transmitted(z, rig, impact, now.x, now.x_rate)) / self.mass, 0.0)

    def face(self, z: State) -> tuple[Value, Value]:
        return z[0], z[1]

    def transmitted(self, z: State, rig: Rig, impact: Impact, x: float, x_rate: float) -> float:
        return float(self.stiffness * (z[0] - x) + self.damping * (z[1] - x_rate) + z[2])

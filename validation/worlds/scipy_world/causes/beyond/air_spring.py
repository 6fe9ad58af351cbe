"""The trapped air of a short chamber is compressed adiabatically and stiffens along the stroke.

Source: p V^n = const with n = 1.4, Beater, Pneumatic Drives (2007), ch. 4.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractActuatorCause, Motion, State


@dataclass(frozen=True)
class AirSpring(AbstractActuatorCause):
    """F = (F_P + p_atm A) ((L/(L - x))^n - 1)."""

    length: float  # L, m
    area: float  # A, m^2
    exponent: float  # n

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        stroke = 0.4 * rig.half_period + 200.0 / rig.k_c
        return cls(stroke * rng.uniform(2.0, 4.0) / max(size, 1e-9), rng.uniform(3e-4, 1e-3), 1.4)

    def opposing(self, z: State, rig: Rig, impact: Impact, now: Motion) -> float:
        # Beyond 95 % of the chamber the law would blow up; a real piston has met its cover by then.
        filled = min(now.x / self.length, 0.95)
        return float((impact.f_p + 1.013e5 * self.area) * ((1.0 - filled) ** -self.exponent - 1.0))

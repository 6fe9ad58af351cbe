"""The pad sits loosely: at some force it slips across a gap, along which the force hardly rises."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractContactCause, State, Value, positive


@dataclass(frozen=True)
class LoosePad(AbstractContactCause):
    """F = k_C (s - r), r = max(0, s - s_1) - max(0, s - s_1 - gap) up to a twentieth of the stiffness."""

    compression: float  # s_1, m
    gap: float  # m

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        return cls(rng.uniform(110.0, 140.0) / rig.k_c, 0.5 * size * 0.3 * rig.impedance / rig.k_c)

    def contact(self, force: Value, z: State, rig: Rig, impact: Impact, s: Value, s_rate: Value) -> Value:
        slipped = positive(s - self.compression) - positive(s - self.compression - self.gap)
        return positive(force - 0.95 * rig.k_c * slipped)

"""The pad bottoms out: a stiff backing behind it, met at once or, by an uneven face, little by little.

Source: foams that densify, Gibson and Ashby, Cellular Solids (1997), ch. 5.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractContactCause, State, Value, positive


@dataclass(frozen=True)
class PadBottoming(AbstractContactCause):
    """F = k_C s + k_b g(s), g = (s - s_b)^2/(2 w) within w beyond s_b and s - s_b - w/2 beyond that."""

    compression: float  # s_b, m
    stiffness: float  # k_b, N/m
    width: float  # w, m, over which the backing is met

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        compression = rng.uniform(0.4, 0.7) * rig.typical_force / rig.k_c
        ratio = rng.uniform(3.0, 8.0) * size
        width = compression * rng.uniform(0.01, 0.25)
        return cls(float(compression), float(ratio * rig.k_c), float(width))

    def contact(self, force: Value, z: State, rig: Rig, impact: Impact, s: Value, s_rate: Value) -> Value:
        beyond, past = (positive(s - self.compression - gap) for gap in (0.0, self.width))
        return force + self.stiffness * (beyond**2 - past**2) / (2.0 * self.width)

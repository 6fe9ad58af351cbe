"""A ribbed pad whose ribs buckle one after the other: the contact softens, then hardens as they touch.

Source: the three regimes of elastomeric honeycombs, Gibson and Ashby, Cellular Solids (1997), ch. 4.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractContactCause, State, Value


@dataclass(frozen=True)
class BucklingPad(AbstractContactCause):
    """F = k_C s - F_b/2 (tanh((s - s_1)/w) + tanh(s_1/w)): a drop of stiffness around s_1."""

    drop: float  # F_b, N
    compression: float  # s_1, m
    width: float  # w, m

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        compression = rng.uniform(130.0, 170.0) / rig.k_c
        width = rng.uniform(0.15, 0.25) * compression
        # The force of one rib must not fall, or the contact would snap through.
        return cls(1.9 * min(size, 1.0) * rig.k_c * width, compression, width)

    def contact(self, force: Value, z: State, rig: Rig, impact: Impact, s: Value, s_rate: Value) -> Value:
        shape = np.tanh((s - self.compression) / self.width) + np.tanh(self.compression / self.width)
        return (force - 0.5 * self.drop * shape) * (s > 0.0)

"""Finite bandwidth of the force measurement: first order, well-damped second order, or Bessel.

Source: Bessel low-pass of the third or fourth order as in strain-gauge amplifiers, Thomson, Proc. IEE 96
(1949) 487.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy import signal

from validation.worlds.filters import low_pass
from validation.worlds.interface import Array, Rig
from validation.worlds.scipy_world.hooks import AbstractSensorCause


@dataclass(frozen=True)
class SensorLag(AbstractSensorCause):
    """A low-pass whose delay at low frequencies is `delay`."""

    delay: float  # s
    order: int  # 1, 2, or 3 and 4 for Bessel
    damping_ratio: float  # of the second order

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        order = int(rng.choice([1, 2, 3, 4], p=[0.4, 0.3, 0.15, 0.15]))
        return cls(0.15 * size * rig.half_period, order, rng.uniform(0.7, 1.2))

    def read(self, time: Array, force: Array) -> Array:
        if self.order <= 2:
            # Second order: delay = 2 ratio/omega.
            omega = 2.0 * self.damping_ratio / self.delay
            first, second = ([1.0], [self.delay, 1.0]), ([1.0], [omega**-2, self.delay, 1.0])
            return low_pass(time, force, *(first if self.order == 1 else second))
        return low_pass(time, force, *signal.bessel(self.order, 1.0 / self.delay, analog=True, norm="delay"))

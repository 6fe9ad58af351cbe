"""The sensor's body has hysteresis: readings lag behind when the force turns back.

Source: Prandtl-Ishlinskii play operators, Visintin, Differential Models of Hysteresis (1994), ch. 3.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Array, Rig
from validation.worlds.scipy_world.hooks import AbstractSensorCause


@dataclass(frozen=True)
class SensorHysteresis(AbstractSensorCause):
    """reading = (1 - sum w) F + sum w play_r(F), play_r following F at a distance of r at most."""

    weight: float  # of each play
    radii: tuple[float, ...]  # r, N

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        widest = rng.uniform(0.1, 0.2) * rig.impedance * 0.3
        return cls(0.3 * min(size, 1.0), (0.3 * widest, 0.6 * widest, widest))

    def read(self, time: Array, force: Array) -> Array:
        reading = (1.0 - self.weight * len(self.radii)) * force
        for radius in self.radii:
            play, trace = 0.0, np.empty_like(force)
            for i, value in enumerate(force.tolist()):
                play = min(max(play, value - radius), value + radius)
                trace[i] = play
            reading += self.weight * trace
        return reading

"""The pad dissipates: Hunt-Crossley with Lankarani-Nikravesh's factor, or Kelvin-Voigt without adhesion.

Sources: Hunt and Crossley, J. Appl. Mech. 42 (1975) 440; Lankarani and Nikravesh, J. Mech. Des. 112 (1990)
369.
"""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractContactCause, State, Value, positive


@dataclass(frozen=True)
class ContactDamping(AbstractContactCause):
    """Hunt-Crossley: F (1 + chi s'), chi = 3 (1 - e^2)/(4 v_0); Kelvin-Voigt: F + c s', never pulling."""

    stage: ClassVar[int] = 1

    per_velocity: float  # chi, s/m; zero chooses Kelvin-Voigt
    viscous: float  # c, N s/m

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        hunt_crossley = rng.random() < 0.6
        reference = rng.uniform(0.2, 0.4)  # m/s, the velocity at which the restitution was measured
        if hunt_crossley:
            restitution = 1.0 - 0.6 * min(size, 1.5)
            return cls(per_velocity=3.0 * (1.0 - restitution**2) / (4.0 * reference), viscous=0.0)
        return cls(per_velocity=0.0, viscous=0.4 * size * rig.impedance)

    def contact(self, force: Value, z: State, rig: Rig, impact: Impact, s: Value, s_rate: Value) -> Value:
        if self.per_velocity:
            return positive(force * (1.0 + self.per_velocity * s_rate))
        return positive(force + self.viscous * s_rate) * (s > 0.0)

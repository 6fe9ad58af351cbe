"""A pad that stiffens: polynomial rubber, a foam that densifies, or a Hertzian power law.

Sources: Johnson, Contact Mechanics (1985), ch. 4; Gibson and Ashby, Cellular Solids (1997), ch. 5.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractContactCause, State, Value, positive


@dataclass(frozen=True)
class ContactHardening(AbstractContactCause):
    """Polynomial: F = k s (1 + b (s/s_r)^p); Hertz: F = k s_r (s/s_r)^n, with s_r a typical compression."""

    gain: float  # b, zero chooses the power law
    power: float  # p or n
    reference: float  # s_r, m

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        hertz = rng.random() < 0.4
        power = rng.choice([1.0, 2.0, rng.uniform(2.5, 4.0)], p=[0.3, 0.4, 0.3])
        reference = 0.3 * rig.impedance / rig.k_c
        if hertz:
            return cls(gain=0.0, power=1.0 + 0.5 * size, reference=reference)
        return cls(gain=0.6 * size, power=float(power), reference=reference)

    def contact(self, force: Value, z: State, rig: Rig, impact: Impact, s: Value, s_rate: Value) -> Value:
        relative = positive(s) / self.reference
        if self.gain:
            return force * (1.0 + self.gain * relative**self.power)
        # The tangent stiffness of a power law starts at zero, so the linear law joins it near the origin.
        return force * (1e-3 + relative) ** (self.power - 1.0)

"""The flange rests on its stop, a stiff unilateral spring that carries what the contact does not.

Once the contact force exceeds the pretension, the mass lifts off and the pretension gives way to a share of
itself, as when the seat of a piston lets pressure past. Source: unilateral contact as in Gilardi and Sharf,
Mech. Mach. Theory 37 (2002) 1213.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractActuatorCause, Motion, State


@dataclass(frozen=True)
class EndStop(AbstractActuatorCause):
    """F = F_P (1 - (1 - share) g) - max(0, held F_P - k_s x), g' = (1 - g)/t_g while F_C > F_P, g(0) = 0."""

    held: float  # share of the pretension that the stop carries at first contact
    share: float  # share of the pretension that opposes the mass once it has left
    stiffness_ratio: float  # k_s/k_C
    opening_time: float  # t_g, s

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        share = min(size, 1.0)
        fully_held = rng.random() < 0.3
        return cls(
            held=1.0 if fully_held and share > 0.3 else share,
            share=share,
            stiffness_ratio=rng.uniform(30.0, 80.0),
            # A stop that holds next to nothing must not keep its whole pretension for long.
            opening_time=rng.uniform(0.003, 0.02) * rig.half_period * max(share, 1e-6),
        )

    def start_share(self) -> float:
        return 1.0 - self.held

    def initial(self, rig: Rig, s: float, force: float) -> tuple[float, ...]:
        return (0.0,)

    def rates(self, z: State, rig: Rig, impact: Impact, now: Motion) -> tuple[float, ...]:
        return ((1.0 - z[0]) / self.opening_time if now.f_c > impact.f_p else 0.0,)

    def opposing(self, z: State, rig: Rig, impact: Impact, now: Motion) -> float:
        stop = max(0.0, self.held * impact.f_p - self.stiffness_ratio * rig.k_c * now.x)
        return float(impact.f_p * (1.0 - (1.0 - self.share) * z[0]) - stop)

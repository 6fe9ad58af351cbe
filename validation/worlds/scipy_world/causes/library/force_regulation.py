"""The pneumatic force control wakes up within the impact: chamber pressure builds up towards F_P.

Source: valve and line as a dead time with a first- or second-order lag, Richer and Hurmuzlu, J. Dyn. Syst.
Meas. Control 122 (2000) 416.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractActuatorCause, Motion, State


@dataclass(frozen=True)
class ForceRegulation(AbstractActuatorCause):
    """p'' + 2 z w p' + w^2 p = w^2 F_P after the delay, or p' = w (F_P - p); p opposes the mass."""

    bandwidth: float  # w, rad/s
    damping_ratio: float  # zero chooses the first order
    delay: float  # s

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        second = rng.random() < 0.4
        ratio = rng.uniform(0.7, 1.2) * second
        # A second-order build-up starts flat, so equal bandwidths would make it the weaker one.
        quickness = rng.uniform(1.5, 3.0) * (2.0 if second else 1.0)
        return cls(
            bandwidth=quickness * size / rig.half_period,
            damping_ratio=ratio,
            delay=rng.uniform(0.0, 0.15) * rig.half_period,
        )

    def initial(self, rig: Rig, s: float, force: float) -> tuple[float, ...]:
        return (0.0, 0.0) if self.damping_ratio else (0.0,)

    def rates(self, z: State, rig: Rig, impact: Impact, now: Motion) -> tuple[float, ...]:
        w = self.bandwidth
        missing = (impact.f_p if now.t > self.delay else 0.0) - z[0]
        if self.damping_ratio:
            return (z[1], w * w * missing - 2.0 * self.damping_ratio * w * z[1])
        return (w * missing,)

    def opposing(self, z: State, rig: Rig, impact: Impact, now: Motion) -> float:
        return float(z[0])

"""The pretension that acts is not the commanded one: a wrong share, an offset, or a ramp that has hardly begun.

Sources: pressure valves and their errors, Beater, Pneumatic Drives (2007); a force that is ramped up from first
contact on, Gadringer et al., Mech. Sci. 13 (2022) 361.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractActuatorCause, Motion, State


@dataclass(frozen=True)
class PretensionError(AbstractActuatorCause):
    """F_0 = (1 + share) F_P + offset acts at first contact; the ramp brings what is missing within `ramp` seconds."""

    share: float
    offset: float  # N
    ramp: float  # s; zero where the error lasts

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        kind, sign = rng.choice(["share", "offset", "ramp"]), float(rng.choice([-1.0, 1.0]))
        large = rng.uniform(0.5, 0.7) * min(size, 1.0)
        ramp = rng.uniform(1.0, 8.0) * rig.half_period
        if kind == "share":
            return cls(sign * large, 0.0, 0.0)
        if kind == "offset":
            return cls(0.0, sign * 50.0 * large, 0.0)
        return cls(-large, 0.0, float(ramp))

    def acting(self, pretension: float) -> float:
        return max((1.0 + self.share) * pretension + self.offset, 0.0)

    def opposing(self, z: State, rig: Rig, impact: Impact, now: Motion) -> float:
        if not self.ramp:
            return 0.0
        missing = impact.f_p * -self.share / (1.0 + self.share)
        return float(missing * min(now.t / self.ramp, 1.0))

"""The pretension that acts is not the commanded one; what is missing comes by a motor that a ramp controls."""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class PretensionError(AbstractSceneCause):
    """F_0 = (1 + share) F_P + offset at first contact; a ramp brings the share `late` of what is missing."""

    component: ClassVar[str] = "actuator"
    stage: ClassVar[int] = -1  # all others see the pretension that acts

    share: float
    offset: float  # N
    late: float  # share of what is missing that comes at all
    ramp: float  # s

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        wrong, sign = rng.random() < 0.6, float(rng.choice([-1.0, 1.0]))
        mix, large = rng.uniform(0.0, 1.0), rng.uniform(0.5, 0.7) * min(size, 1.0)
        late, ramp = rng.uniform(0.5, 1.0), float(rng.uniform(1.0, 8.0) * rig.half_period)
        if wrong:
            return cls(sign * large * mix, sign * 50.0 * large * (1.0 - mix), 0.0, ramp)
        return cls(-large, 0.0, late, ramp)

    def build(self, scene: Scene) -> None:
        commanded = scene.impact.f_p
        acting = max((1.0 + self.share) * commanded + self.offset, 0.0)
        scene.impact = Impact(scene.impact.v_e, acting)
        missing = self.late * (commanded - acting)
        if missing:
            scene.add_motor("x", -1.0, lambda t: missing * np.minimum(t / self.ramp, 1.0))

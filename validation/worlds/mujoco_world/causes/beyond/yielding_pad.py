"""The pad yields and stays compressed: MuJoCo's plastic spring."""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class YieldingPad(AbstractSceneCause):
    """F = k_C (s - q), where q grows so that s - q never exceeds s_y."""

    component: ClassVar[str] = "contact"

    yield_compression: float  # s_y, m

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        share = 1.7 - min(size, 1.0) * rng.uniform(0.9, 1.0)  # 1.7 is beyond every campaign
        return cls(share * rig.typical_force / rig.k_c)

    def build(self, scene: Scene) -> None:
        scene.contact_yield = max(self.yield_compression, 1.2 * scene.s_0)

"""The amplifier clips: no reading above its range."""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Array, Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class SensorClipping(AbstractSceneCause):
    """reading = min(F, limit)."""

    component: ClassVar[str] = "sensor"

    limit: float  # N

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        share = 1.7 - min(size, 1.0) * rng.uniform(0.9, 1.0)  # 1.7 is beyond every campaign
        return cls(share * rig.typical_force)

    def build(self, scene: Scene) -> None:
        pass

    def read(self, time: Array, reading: Array, record: dict[str, Array]) -> Array:
        return np.minimum(reading, self.limit)

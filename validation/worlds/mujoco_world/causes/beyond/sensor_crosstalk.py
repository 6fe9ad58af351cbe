"""The cell picks up the flange's acceleration through a shared frame."""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Array, Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class SensorCrosstalk(AbstractSceneCause):
    """reading = F + mass x''."""

    component: ClassVar[str] = "sensor"

    mass: float  # kg, either sign

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        return cls(float(rng.choice([-1.0, 1.0]) * 0.2 * size * rig.m))

    def build(self, scene: Scene) -> None:
        scene.watch("x")

    def read(self, time: Array, reading: Array, record: dict[str, Array]) -> Array:
        return reading + self.mass * np.gradient(record["x_vel"], time)

"""Gain error of the force measurement."""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Array, Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class SensorScale(AbstractSceneCause):
    """reading = gain F, 20 % off at `size` 1."""

    component: ClassVar[str] = "sensor"

    gain: float

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        return cls(float(1.0 + rng.choice([-1.0, 1.0]) * 0.2 * size))

    def build(self, scene: Scene) -> None:
        pass

    def read(self, time: Array, reading: Array, record: dict[str, Array]) -> Array:
        return self.gain * reading

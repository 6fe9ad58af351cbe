"""Weight of all that moves with the flange, at an inclination; the robot carries its own."""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class Gravity(AbstractSceneCause):
    """F = m g sin(inclination), either sign; `size` 1 is up to upright."""

    component: ClassVar[str] = "actuator"

    inclination: float  # rad, positive where the weight opposes compression

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        sign = rng.choice([-1.0, 1.0])
        return cls(float(sign * np.arcsin(min(size, 1.0) * rng.uniform(0.7, 1.0))))

    def build(self, scene: Scene) -> None:
        scene.spec.option.gravity = [-9.81 * np.sin(self.inclination), 0.0, 0.0]

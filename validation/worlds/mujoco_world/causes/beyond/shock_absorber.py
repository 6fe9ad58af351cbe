"""A damper that closes with speed, as cushions of cylinders do: MuJoCo's cubic joint damping."""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class ShockAbsorber(AbstractSceneCause):
    """F = c_2 x' |x'| + c_3 x'^3."""

    component: ClassVar[str] = "actuator"

    quadratic: float  # c_2, N s^2/m^2
    cubic: float  # c_3, N s^3/m^3

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        mix, strength = rng.uniform(0.3, 0.7), rng.uniform(0.3, 0.7) * size * rig.impedance
        return cls(strength * mix / 0.3, strength * (1.0 - mix) / 0.3**2)

    def build(self, scene: Scene) -> None:
        scene.x.damping[1] += self.quadratic
        scene.x.damping[2] += self.cubic

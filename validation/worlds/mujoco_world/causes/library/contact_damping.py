"""The pad dissipates: MuJoCo's polynomial damper beside the contact spring, until contact is lost."""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class ContactDamping(AbstractSceneCause):
    """F = spring + c_1 s' + c_2 s' |s'|."""

    component: ClassVar[str] = "contact"

    linear: float  # c_1, N s/m
    quadratic: float  # c_2, N s^2/m^2

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        damper, mix = 0.4 * size * rig.impedance, rng.uniform(0.0, 0.6)
        return cls(damper * (1.0 - mix), damper * mix / 0.3)

    def build(self, scene: Scene) -> None:
        scene.damping[0] += self.linear
        scene.damping[1] += self.quadratic

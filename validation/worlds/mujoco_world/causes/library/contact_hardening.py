"""A pad that stiffens: MuJoCo's polynomial spring."""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class ContactHardening(AbstractSceneCause):
    """F = k_C s (1 + b_2 s/s_r + b_3 (s/s_r)^2), s_r a typical compression."""

    component: ClassVar[str] = "contact"

    quadratic: float  # b_2
    cubic: float  # b_3
    reference: float  # s_r, m

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        mix = rng.uniform(0.0, 1.0)
        return cls(0.6 * size * mix, 0.6 * size * (1.0 - mix), 0.3 * rig.impedance / rig.k_c)

    def build(self, scene: Scene) -> None:
        scene.stiffness[1] += scene.rig.k_c * self.quadratic / self.reference
        scene.stiffness[2] += scene.rig.k_c * self.cubic / self.reference**2

"""Dry friction of guide and seals: MuJoCo's joint friction loss.

Source: Todorov, Convex and analytically-invertible dynamics with contacts and constraints, ICRA 2014: a
convex constraint whose force may reach the loss and which creeps a little below it.
"""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene

USUAL = 80.0  # N, pretension


@dataclass(frozen=True)
class CoulombFriction(AbstractSceneCause):
    """|F| <= loss, opposed to the motion, and a viscous part of the seals; `size` 1 is 40 N at a pretension of 80 N.

    loss = force_n (1 - pressed + pressed F_P/80 N): seals press harder under pressure.
    """

    component: ClassVar[str] = "actuator"

    force_n: float
    viscous: float  # N s/m
    pressed: float  # share that grows with the pretension

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        return cls(40.0 * size, 40.0 * size * rng.uniform(0.0, 0.4), rng.uniform(0.0, 0.5))

    def build(self, scene: Scene) -> None:
        scene.x.frictionloss = self.force_n * (1.0 + self.pressed * (scene.impact.f_p / USUAL - 1.0))
        scene.x.solref_friction = [1e-4, 1.0]
        scene.x.damping[0] += self.viscous

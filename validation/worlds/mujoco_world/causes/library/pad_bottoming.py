"""The pad bottoms out: past a compression the contact is far stiffer, the upper limit of its tendon."""

from dataclasses import dataclass
from itertools import chain
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene
from validation.worlds.setup import HELD_OUT, PRETENSIONS

BEYOND = 1.7  # of the typical force: no campaign reaches it
# N: no impact begins at the bottom, of which MuJoCo's constraint would push it off
PRESSED = 1.1 * max(chain(*PRETENSIONS, HELD_OUT[1]))


@dataclass(frozen=True)
class PadBottoming(AbstractSceneCause):
    """F = k_C s up to s_b, where MuJoCo's soft constraint takes over."""

    component: ClassVar[str] = "contact"

    compression: float  # s_b, m
    stiffness_ratio: float  # of the constraint, which acts where it asks for more than the pad gives

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        nearest = rng.uniform(0.4, 0.7)
        share = nearest + (BEYOND - nearest) * (1.0 - min(size, 1.0)) ** 4
        return cls(max(share * rig.typical_force, PRESSED) / rig.k_c, rng.uniform(20.0, 60.0))

    def build(self, scene: Scene) -> None:
        scene.limit_stiffness = self.stiffness_ratio * scene.rig.omega**2
        scene.contact_limit = self.compression

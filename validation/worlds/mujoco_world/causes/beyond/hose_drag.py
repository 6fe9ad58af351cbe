"""A hose or cable hangs slack until the flange has moved, then pulls: a tendon with a deadband."""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Rig
from validation.worlds.mujoco_world.scene import SLACK, AbstractSceneCause, Scene


@dataclass(frozen=True)
class HoseDrag(AbstractSceneCause):
    """F = k_h max(0, x - slack)."""

    component: ClassVar[str] = "actuator"

    slack: float  # m
    stiffness: float  # k_h, N/m

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        stroke = 0.25 * rig.half_period
        return cls(rng.uniform(0.1, 0.35) * stroke, rig.k_c * rng.uniform(0.05, 0.2) * size)

    def build(self, scene: Scene) -> None:
        scene.add_tendon(
            "hose", {"x": 1.0}, stiffness=[self.stiffness, 0.0, 0.0], springlength=[SLACK, self.slack]
        )

"""A viscoelastic pad: a second tendon that ends on a light body held by a damper (Zener's solid)."""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class PadRelaxation(AbstractSceneCause):
    """F = (1 - a) k_C s + a k_C (s - z), c z' = a k_C (s - z) on a body of a few grams."""

    component: ClassVar[str] = "contact"

    share: float  # a
    time: float  # c/(a k_C), s

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        return cls(0.5 * size, rig.half_period * float(np.exp(rng.uniform(np.log(0.08), np.log(0.5)))))

    def build(self, scene: Scene) -> None:
        stiffness = self.share * scene.rig.k_c
        scene.stiffness[0] -= stiffness
        damping = stiffness * self.time
        # 30 us for mass/damper: far below the relaxation time, yet slow enough for the integrator.
        body, joint = scene.add_body(scene.face, "dashpot", 3e-5 * damping)
        body.gravcomp = 1.0
        joint.damping[0] = damping
        scene.branches.append(("branch", "dashpot", stiffness))

"""A pad or backing plate with a mass of its own: a second body between contact and flange."""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class PadMass(AbstractSceneCause):
    """m_p x_p'' = F_C - F_p, F_p = k_p (x_p - x) + c_p (x_p' - x') + F_C(0)."""

    component: ClassVar[str] = "contact"

    mass: float  # m_p, kg
    stiffness: float  # k_p, N/m
    damping: float  # c_p, N s/m

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        mass = 0.3 * max(size, 1e-3) * rig.m
        stiffness = rig.k_c * rng.uniform(2.0, 6.0) / max(size, 1e-9) ** 0.5
        ratio = rng.uniform(0.02, 0.15)
        return cls(mass, stiffness, float(2.0 * ratio * np.sqrt(stiffness * mass)))

    def build(self, scene: Scene) -> None:
        scene.fastest = max(scene.fastest, float(np.sqrt(self.stiffness / self.mass)))
        scene.face, _ = scene.add_body(scene.spec.worldbody, "pad", self.mass)
        scene.face_joint = "pad"

        def mount() -> None:
            scene.add_tendon(
                "pad_spring", {"pad": 1.0, "x": -1.0}, stiffness=[self.stiffness, 0.0, 0.0],
                damping=[self.damping, 0.0, 0.0], springlength=[-scene.start_force / self.stiffness] * 2,
            )  # fmt: skip

        scene.at_compile.append(mount)

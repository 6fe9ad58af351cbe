"""Play in the robot's drive: the spring that holds its link has a deadband."""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class RobotBacklash(AbstractSceneCause):
    """M u'' + c u' + k min(0, u + gap) = -F_C."""

    component: ClassVar[str] = "robot"
    stage: ClassVar[int] = 1  # a compliant robot, which is heavy, would hold a link behind it in place

    mass: float  # kg
    stiffness: float  # N/m
    damping: float  # N s/m
    gap: float  # m

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        mass = rig.m * rng.uniform(2.0, 4.0)
        stiffness = rig.k_c * rng.uniform(20.0, 40.0) / max(size, 1e-3)
        gap = 0.25 * size * 0.3 * rig.impedance / rig.k_c
        return cls(mass, stiffness, float(0.1 * np.sqrt(rig.k_c * mass) * size), gap)

    def build(self, scene: Scene) -> None:
        scene.robot, joint = scene.add_body(scene.robot, "loose_link", self.mass)
        scene.robot.gravcomp = 1.0
        scene.robot_joints.append("loose_link")
        joint.damping[0] = self.damping
        scene.add_tendon(
            "drive", {"loose_link": 1.0}, stiffness=[self.stiffness, 0.0, 0.0], springlength=[-self.gap, 0.0]
        )

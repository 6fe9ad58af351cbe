"""The robot yields: a body on a sprung and damped joint of the carriage."""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class RobotCompliance(AbstractSceneCause):
    """M u'' + c u' + k u = -F_C, u the robot's lead on its carriage."""

    component: ClassVar[str] = "robot"

    mass: float  # kg
    stiffness: float  # N/m
    damping: float  # N s/m

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        size = max(size, 1e-9)
        mass = rig.m * rng.uniform(1.0, 4.0) / size
        stiffness = rig.k_c * rng.uniform(0.4, 1.5) / size
        ratio = rng.uniform(0.02, 0.3)
        return cls(mass, stiffness, float(2.0 * ratio * np.sqrt(stiffness * mass)))

    def build(self, scene: Scene) -> None:
        scene.robot, joint = scene.add_body(scene.robot, "link", self.mass)
        scene.robot.gravcomp = 1.0
        scene.robot_joints.append("link")
        joint.stiffness[0], joint.damping[0] = self.stiffness, self.damping

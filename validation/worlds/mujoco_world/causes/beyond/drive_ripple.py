"""The drive's force ripples on its way, as of a motor with cogging."""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.interface import Rig
from validation.worlds.mujoco_world.scene import CARRIAGE_MASS, AbstractSceneCause, Scene


@dataclass(frozen=True)
class DriveRipple(AbstractSceneCause):
    """The carriage is accelerated by A w^2 cos(w t + phase) on its path."""

    component: ClassVar[str] = "robot"

    amplitude: float  # A, m
    frequency: float  # w/2 pi, Hz
    phase: float  # rad

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        frequency = rng.uniform(1.2, 3.0) / rig.half_period
        return cls(50.0 * size / rig.k_c, frequency, rng.uniform(0.0, 2.0 * np.pi))

    def build(self, scene: Scene) -> None:
        w = 2.0 * np.pi * self.frequency
        scene.add_motor(
            "carriage", CARRIAGE_MASS, lambda time: self.amplitude * w**2 * np.cos(w * time + self.phase)
        )

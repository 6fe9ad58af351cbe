"""A plate on the sensor, behind which the sensor's own mounting gives way as well.

A filter and no body, as the other sensors of this world: a body would also read the robot's braking. Source: Maranzano
and Hancock (2016).
"""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.filters import low_pass
from validation.worlds.interface import Array, Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class FixtureMass(AbstractSceneCause):
    """Two masses on springs and dampers in series; what the last of these carry is read."""

    component: ClassVar[str] = "sensor"

    frequencies: tuple[float, float]  # of plate and mounting, each by itself, rad/s
    damping_times: tuple[float, float]  # damping over stiffness of each, s

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        heavy = rng.uniform(5.0, 12.0) * rig.omega
        times = 2.0 * rng.uniform(0.01, 0.08) / heavy, 2.0 * rng.uniform(0.05, 0.2) / (20.0 * heavy)
        lower = heavy / np.sqrt(max(size, 1e-9))
        return cls((float(lower), float(lower * rng.uniform(10.0, 30.0))), (float(times[0]), float(times[1])))

    def build(self, scene: Scene) -> None:
        pass

    def read(self, time: Array, reading: Array, record: dict[str, Array]) -> Array:
        for omega, tau in zip(self.frequencies, self.damping_times, strict=True):
            reading = low_pass(time, reading, [tau, 1.0], [omega**-2, tau, 1.0])
        return reading

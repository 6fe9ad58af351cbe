"""The mounting rings in two lightly damped modes; the rest of the force passes rigidly.

A body on a sprung joint would ring too, but its inertia would also read the robot's braking. Source: modal
superposition, Ewins, Modal Testing (2000), ch. 2.
"""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.filters import low_pass
from validation.worlds.interface import Array, Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class SensorResonance(AbstractSceneCause):
    """reading = F + sum share_i (y_i - F), y_i'' + 2 ratio w_i y_i' + w_i^2 y_i = w_i^2 F."""

    component: ClassVar[str] = "sensor"

    frequencies: tuple[float, float]  # w_i/2 pi, Hz
    shares: tuple[float, float]  # participations
    damping_ratio: float

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        lower = rng.uniform(5.0, 12.0) * rig.omega / (2.0 * np.pi)
        second = rng.uniform(0.0, 0.25)
        share = min(size, 1.0)
        return cls(
            frequencies=(lower, lower * rng.uniform(1.8, 2.6)),
            shares=(share * (1.0 - second), share * second),
            damping_ratio=rng.uniform(0.01, 0.08),
        )

    def build(self, scene: Scene) -> None:
        pass

    def read(self, time: Array, reading: Array, record: dict[str, Array]) -> Array:
        ringing = np.zeros_like(reading)
        for frequency, share in zip(self.frequencies, self.shares, strict=True):
            omega = 2.0 * np.pi * frequency
            mode = low_pass(time, reading, [1.0], [omega**-2, 2.0 * self.damping_ratio / omega, 1.0])
            ringing += share * (mode - reading)
        return reading + ringing

"""A guarded stop: the carriage is braked to rest after a reaction time, the brake building up with a lag."""

from dataclasses import dataclass
from typing import ClassVar, Self

import mujoco
import numpy as np

from validation.worlds.interface import Array, Rig
from validation.worlds.mujoco_world.scene import CARRIAGE_MASS, AbstractSceneCause, Scene


@dataclass(frozen=True)
class RobotDeceleration(AbstractSceneCause):
    """tau b' = a - b from the delay on, until what a has taken away is the velocity; v' = -b."""

    component: ClassVar[str] = "robot"

    delay: float  # s
    deceleration: float  # a, m/s^2
    lag: float  # tau, s

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        deceleration = 0.25 * rng.uniform(0.6, 1.0) * size / rig.half_period
        return cls(
            rng.uniform(0.0, 0.2) * rig.half_period, deceleration, rng.uniform(0.02, 0.2) * rig.half_period
        )

    def build(self, scene: Scene) -> None:
        def brake(time: Array) -> Array:
            stop = self.delay + scene.impact.v_e / self.deceleration
            return np.where((time >= self.delay) & (time < stop), self.deceleration, 0.0)

        scene.add_motor(
            "carriage", -CARRIAGE_MASS, brake,
            dyntype=mujoco.mjtDyn.mjDYN_FILTEREXACT, dynprm=[self.lag] + [0.0] * 9,
        )  # fmt: skip

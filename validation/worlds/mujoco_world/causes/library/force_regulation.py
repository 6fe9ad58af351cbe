"""The pneumatic force control wakes up within the impact, as actuator dynamics.

Forms: MuJoCo's first-order filter, or its integrator: a valve that fills the chamber at a constant rate until
F_P is reached.
"""

from dataclasses import dataclass
from typing import ClassVar, Self

import mujoco
import numpy as np

from validation.worlds.interface import Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class ForceRegulation(AbstractSceneCause):
    """p' = (F_P - p)/tau after the delay, or p' = F_P/tau up to F_P; p opposes the mass."""

    component: ClassVar[str] = "actuator"

    time: float  # tau, s
    delay: float  # s
    constant_rate: bool

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        time = rig.half_period / (rng.uniform(1.0, 2.5) * max(size, 1e-9))
        return cls(time, rng.uniform(0.0, 0.15) * rig.half_period, bool(rng.random() < 0.4))

    def build(self, scene: Scene) -> None:
        f_p = scene.impact.f_p
        if self.constant_rate:
            dynamics = {
                "dyntype": mujoco.mjtDyn.mjDYN_INTEGRATOR,
                "actlimited": mujoco.mjtLimited.mjLIMITED_TRUE,
                "actrange": [0.0, max(f_p, 1e-9)],
            }
            valve = f_p / self.time
        else:
            dynamics = {"dyntype": mujoco.mjtDyn.mjDYN_FILTEREXACT, "dynprm": [self.time] + [0.0] * 9}
            valve = f_p
        scene.add_motor("x", -1.0, lambda time: np.where(time >= self.delay, valve, 0.0), **dynamics)

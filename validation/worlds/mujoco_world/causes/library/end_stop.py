"""The flange rests on its stop: the lower limit of its joint, a soft constraint of MuJoCo's solver."""

from dataclasses import dataclass
from typing import ClassVar, Self

import mujoco
import numpy as np

from validation.worlds.interface import Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class EndStop(AbstractSceneCause):
    """A motor presses the mass with F_P on the limit at x = 0; contact starts at (1 - held) F_P.

    When the contact, its face at rest, has reached F_P, a valve lowers the motor to share F_P.
    """

    component: ClassVar[str] = "actuator"

    held: float  # share of the pretension that is missing at first contact
    share: float  # share of the pretension that opposes the mass

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        share = min(size, 1.0)
        fully_held = rng.random() < 0.3
        return cls(1.0 if fully_held and share > 0.3 else share, share)

    def build(self, scene: Scene) -> None:
        scene.start_share *= 1.0 - self.held
        scene.x.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        scene.x.range = [0.0, 1.0]
        scene.x.solref_limit = [5e-5, 1.0]
        f_p, rate = scene.impact.f_p, scene.rig.k_c * scene.impact.v_e
        scene.add_motor("x", -1.0, lambda t: np.where(t < self.held * f_p / rate, f_p, self.share * f_p))

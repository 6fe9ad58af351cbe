"""A guarded stop: the robot brakes after its reaction time, at a constant rate or along an s-shaped profile.

Sources: stop category 1 of IEC 60204-1; s-shaped profiles in Biagiotti and Melchiorri, Trajectory Planning
for Automatic Machines and Robots (2008), ch. 3.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractRobotCause, State, Value, positive


@dataclass(frozen=True)
class RobotDeceleration(AbstractRobotCause):
    """Constant a down to rest, or v (1 - share (1 - cos(pi w/T))/2), w = t - delay in 0..T."""

    delay: float  # s
    deceleration: float  # a, m/s^2; zero chooses the s-shape
    share: float  # of the velocity that the s-shape takes away
    duration: float  # T, s

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        s_shaped = rng.random() < 0.4
        delay = rng.uniform(0.0, 0.25) * rig.half_period
        duration = rng.uniform(0.6, 1.2) * rig.half_period
        constant = 0.25 * rng.uniform(0.6, 1.0) / rig.half_period
        if s_shaped:
            return cls(delay, 0.0, min(0.8 * size, 1.0), duration)
        return cls(delay, constant * size, 0.0, duration)

    def offset(self, t: Value, z: State, rig: Rig, impact: Impact) -> tuple[Value, Value]:
        since = positive(t - self.delay)
        v = impact.v_e
        if self.deceleration:
            beyond = positive(since - v / self.deceleration)
            braking = since - beyond
            return -0.5 * self.deceleration * braking**2 - v * beyond, -self.deceleration * braking
        beyond = positive(since - self.duration)
        phase = np.pi * (since - beyond) / self.duration
        lost = 0.5 * self.share * v
        behind = lost * self.duration / np.pi * (phase - np.sin(phase)) + 2.0 * lost * beyond
        return -behind, -lost * (1.0 - np.cos(phase))

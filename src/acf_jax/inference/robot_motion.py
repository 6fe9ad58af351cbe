"""The robot's measured velocity in the equations of motion, s = integral of it - x, and how far it may be off."""

from collections.abc import Sequence
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.interpolate import make_interp_spline

from acf_jax.dataset import RobotVelocity
from acf_jax.effects import AbstractEffect
from acf_jax.effects._interface import Scalar, States
from acf_jax.model import Impact, Rig

NODES = 128  # at which the simulator is given a velocity: some 2 kHz, beyond what a robot follows
WALKS = 2  # parts of each trial's error; the last part is the delay, which all trials share
ERRORS = WALKS + 1
LEAST_BEFORE = 5  # samples before contact that tell the scatter of a velocity


class MeasuredMotion(AbstractEffect):
    """The robot moves as it was measured: r' = sum of w_k u_k(t), r(0) = 0, with r in addition to v_E t.

    u_0 is the measured velocity less v_E, w_0 = 1; the others are one standard deviation of each part of its error.
    Linear between nodes. Not in the library: nobody has to guess it.
    """

    component = "robot"
    title = "Measured motion"

    spacing: Scalar | float  # s, between nodes
    velocity: Float[Array, "parts nodes"]  # m/s
    displacement: Float[Array, "parts nodes"]  # m
    weight: Float[Array, " parts"]

    def robot_displacement(self, rig: Rig, impact: Impact, t: Scalar, state: States) -> tuple[Scalar, Scalar]:
        known = jnp.minimum(t, (NODES - 1) * self.spacing)
        k = jnp.clip((known / self.spacing).astype(int), 0, NODES - 2)
        since = known - k * self.spacing
        begin, end = self.velocity[:, k], self.velocity[:, k + 1]
        gained = (end - begin) * since / self.spacing
        moved = self.displacement[:, k] + (begin + gained / 2) * since + (begin + gained) * (t - known)
        return self.weight @ moved, self.weight @ (begin + gained)


class RobotMotion(NamedTuple):
    """The robot's velocities of some trials at even times: parts as those of `MeasuredMotion`, zero without motion."""

    spacing: float  # s, between nodes
    velocity: np.ndarray  # (trials, 1 + ERRORS, NODES) m/s

    @property
    def displacement(self) -> np.ndarray:
        """(trials, 1 + ERRORS, NODES) m, the integral of the velocity, which is linear between nodes."""
        step = 0.5 * self.spacing * (self.velocity[..., 1:] + self.velocity[..., :-1])
        return np.pad(np.cumsum(step, axis=-1), ((0, 0), (0, 0), (1, 0)))

    def steady(self) -> "RobotMotion":
        """That of robots that keep their speed, and are known to."""
        return self._replace(velocity=np.zeros_like(self.velocity))

    def of(self, trials: np.ndarray) -> "RobotMotion":
        """That of some trials, given by index."""
        return self._replace(velocity=self.velocity[trials])


def robot_motion(
    motions: Sequence[RobotVelocity | None], v_e: np.ndarray, std: float, late: np.ndarray, end: float
) -> RobotMotion | None:
    """What the simulator is given of the measured velocities; None where there are none.

    Their samples err independently, so that the robot's path errs as a random walk: its two largest Karhunen-Loeve
    parts over the impact hold 90 % of that. And samples may belong to another time by their interval, the same in all
    trials: a robot measures with a bandwidth and a clock of its own, and a slow filter is a delay to first order. An
    error that lasts is that of the contact velocity.

    **Arguments:** `motions`: of each trial. `v_e`: (trials,) m/s, in addition to which they are given. `std`: m/s, of a
    sample. `late`: (trials,) s, time of first contact on the clock of the trial. `end`: s, of the simulation.
    """
    if not any(motions):
        return None
    spacing = end / (NODES - 1)
    time = spacing * np.arange(NODES)
    velocity = np.zeros((len(motions), 1 + ERRORS, NODES))
    for parts, motion, v, begin in zip(velocity, motions, v_e, late, strict=True):
        if motion is not None:
            parts[0] = _even(motion, begin + time, spacing) - v
            parts[1:] = _errors(motion, parts[0], time, spacing, std, motion.time[-1] - begin)
    return RobotMotion(spacing, velocity)


def _even(motion: RobotVelocity, time: np.ndarray, spacing: float) -> np.ndarray:
    """The velocity at even times: the mean over the spacing about each, linear between samples, held at their ends."""
    path = make_interp_spline(motion.time, motion.value, 1).antiderivative()

    def at(t: np.ndarray) -> np.ndarray:
        inside = np.clip(t, motion.time[0], motion.time[-1])
        beyond = np.where(t > inside, motion.value[-1], motion.value[0])
        return np.asarray(path(inside) + beyond * (t - inside))

    return (at(time + spacing / 2) - at(time - spacing / 2)) / spacing


def _errors(
    motion: RobotVelocity, velocity: np.ndarray, time: np.ndarray, spacing: float, std: float, last: float
) -> np.ndarray:
    """(ERRORS, nodes) m/s, one standard deviation of each part of the error of what is measured until `last`, s."""
    interval = motion.step
    end = min(time[-1], last)
    share = np.minimum(time / end, 1.0)
    walk = std * np.sqrt(2 * interval / end)
    waves = [walk * np.cos((k + 0.5) * np.pi * share) for k in range(WALKS)]
    return np.array([*waves, interval * np.gradient(velocity, spacing)])


def velocity_std(motions: Sequence[RobotVelocity | None]) -> float | None:
    """Scatter of a sample of the velocities before contact, about a line, m/s; None where there are too few."""
    squares, count = 0.0, 0
    for motion in motions:
        if motion is not None and (motion.time < 0).sum() >= LEAST_BEFORE:
            time, value = motion.time[motion.time < 0], motion.value[motion.time < 0]
            line = np.polynomial.Polynomial.fit(time, value, 1)
            squares += float(((value - line(time)) ** 2).sum())
            count += value.size - 2
    return float(np.sqrt(squares / count)) if count else None

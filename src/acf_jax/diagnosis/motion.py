"""What the robot did in the impacts, where that was measured: what it changes, and what a fit infers of it."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from acf_jax.inference.fit import Fit
from acf_jax.inference.forward import forward, system_of
from acf_jax.inference.interpolation import at_times
from acf_jax.inference.linear import motion_errors
from acf_jax.inference.observations import Observations
from acf_jax.simulator.robot import robot_velocity

TOLD = 1.0  # standard deviations of the noise; a motion that changes the force by less changes nothing


def inferred_motion(o: Observations, fitted: Fit) -> tuple[np.ndarray, np.ndarray]:
    """The robot's velocity in every trial as a fit has it: the measured one with its errors, and what effects add.

    **Returns:** (n,) s after first contact; (trials, n) m/s.
    """
    assert o.robot is not None
    grid = fitted.grid
    theta = np.tile(fitted.physical, (len(o.names), 1))
    impacts = np.column_stack([o.v_e, o.f_p]) + fitted.nuisance[:, :2] * o.nuisance_std[:, :2]
    z = np.column_stack([theta, impacts, motion_errors(o, fitted.nuisance, fitted.common)])
    make = partial(system_of, fitted.explanation, spacing=o.robot.spacing)

    @jax.jit
    @jax.vmap
    def run(z: jax.Array, *moves: jax.Array) -> jax.Array:
        return robot_velocity(make(z, *moves), grid.h, grid.steps + 1)

    velocity = run(jnp.asarray(z), jnp.asarray(o.robot.velocity), jnp.asarray(o.robot.displacement))
    return grid.h * np.arange(grid.steps + 1), np.asarray(velocity)


def statement(o: Observations, recalibrated: Fit) -> str:
    """By how much the measured motion changes the force against the commanded one, where that is more than noise."""
    if o.robot is None:
        return ""
    there = recalibrated.physical, o.v_e, o.f_p, recalibrated.grid
    h = recalibrated.grid.h
    as_measured, as_told = forward((), *there, robot=o.robot), forward((), *there)
    changed = [
        at_times(a - b, o.time[i, used], h, contact)
        for i, (a, b, contact) in enumerate(
            zip(as_measured.sensed, as_told.sensed, as_measured.contact, strict=True)
        )
        if (used := o.traced[i]).any()
    ]
    rms = float(np.sqrt(np.mean(np.concatenate(changed) ** 2))) if changed else 0.0
    if rms < TOLD * o.noise.std:
        return ""
    return (
        "the robot did not keep its commanded speed: as measured, it changes the recalibrated model's force by"
        f" {rms:.3g} N RMS. That is no part of the gap; but predictions for other impacts, as all of `model.json`, are"
        " for a robot that keeps its speed"
    )

"""How the robot moves in an impact with effects."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from acf_jax.effects._interface import Scalar
from acf_jax.simulator.simulate import Moving, System, advance, start


def robot_velocity(system: System, h: Scalar | float, samples: int) -> Float[Array, " samples"]:
    """The robot's velocity towards the part on the grid 0, h, 2h, ..., m/s: v_E and what effects add to it."""
    h = jnp.asarray(h, float)

    def velocity(t: Scalar, moving: Moving) -> Scalar:
        states = zip(system.effects, moving.y.states, strict=True)
        added = [e.robot_displacement(system.rig, system.impact, t, q)[1] for e, q in states]
        return system.impact.v_e + sum(added)

    def step(moving: Moving, k: Int[Array, ""]) -> tuple[Moving, Scalar]:
        return advance(system, k, h, moving), velocity(k * h, moving)

    first = start(system, h, has_sensor=False)
    return jax.lax.scan(step, first, jnp.arange(samples))[1]

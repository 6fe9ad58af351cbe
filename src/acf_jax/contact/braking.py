"""The robot's stop in numbers, and its braking as the simulator's effects see it."""

import jax.numpy as jnp
from jaxtyping import Array, Bool

from acf_jax.contact.ending import Ending
from acf_jax.effects import AbstractEffect, strength
from acf_jax.effects._interface import Scalar
from acf_jax.model import Impact, Rig

LEAST_SPEED = 1e-9  # m/s, of a robot that stops
ROUNDING = 1e-6  # of a travel: no stroke is known better


def stopping_time(ending: Ending, v_e: Scalar | float) -> Scalar:
    """When the robot has stopped, s: infinite where nothing tells."""
    v = jnp.asarray(v_e, float)
    is_braking = jnp.isfinite(ending.deceleration)
    braking = ending.reaction + v / jnp.where(is_braking, ending.deceleration, 1.0)
    told = jnp.minimum(ending.stop_after, jnp.where(is_braking, braking, jnp.inf))
    by_travel = jnp.where(v > 0, ending.travel / jnp.where(v > 0, v, 1.0), jnp.inf)
    return jnp.where(jnp.isfinite(told), told, by_travel)


def stopping_travel(ending: Ending, v_e: Scalar | float) -> Scalar:
    """How far the robot has come by then, m: infinite where nothing tells."""
    v = jnp.asarray(v_e, float)
    time = stopping_time(ending, v)
    is_braking = jnp.isfinite(ending.deceleration)
    saved = v**2 / (2 * jnp.where(is_braking, ending.deceleration, 1.0))
    return jnp.where(v > 0, v * time - jnp.where(is_braking, saved, 0.0), 0.0)


def is_within_travel(ending: Ending, v_e: Scalar | float) -> Bool[Array, ""]:
    """Whether the robot stops before the travel that is left is used up."""
    return stopping_travel(ending, v_e) <= ending.travel * (1 + ROUNDING)


def braking(ending: Ending, v_e: Scalar, at_once: Scalar) -> tuple[Scalar, Scalar]:
    """From when the robot brakes, s, and with how much, m/s^2; infinite where nothing tells.

    **Arguments:** `at_once`: s, in which a robot stops that has kept its speed until it stops.
    """
    brakes = jnp.isfinite(ending.deceleration)
    stop = stopping_time(ending, v_e)
    abrupt = jnp.where(jnp.isfinite(stop), jnp.maximum(v_e, LEAST_SPEED) / at_once, jnp.inf)
    return jnp.where(brakes, ending.reaction, stop), jnp.where(brakes, ending.deceleration, abrupt)


class Braking(AbstractEffect):
    """The robot keeps its speed until `reaction`, then brakes with a constant deceleration until it stands still.

    Not a candidate of a diagnosis, which has one of its own: this one is what a user states, and the robot carries the
    flange, whose mass goes on by itself.
    """

    component = "robot"
    title = "Stated braking"

    deceleration: Scalar = strength("m/s^2", 0.0, 200.0, (1.0, 5.0), 5.0, "deceleration")
    reaction: Scalar = strength("s", 0.0, 10.0, (0.01, 0.1), 0.1, "time from contact to braking")

    def carrier_displacement(self, rig: Rig, impact: Impact, t: Scalar) -> tuple[Scalar, Scalar]:
        is_braking = jnp.isfinite(self.deceleration)
        a = jnp.where(is_braking, self.deceleration, 1.0)
        since = jnp.clip(t - self.reaction, 0.0, impact.v_e / a)
        at_rest = jnp.maximum(t - self.reaction - impact.v_e / a, 0.0)
        lost = a * since * since / 2 + impact.v_e * at_rest
        return jnp.where(is_braking, -lost, 0.0), jnp.where(is_braking, -a * since, 0.0)

"""The force of one contact, followed until the robot has stopped and the flange that it carries is at rest, too."""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from acf_jax.contact.body import Body
from acf_jax.contact.braking import Braking, braking, stopping_time
from acf_jax.contact.ending import Ending
from acf_jax.contact.recoil import Recoil
from acf_jax.effects import AbstractEffect, Motion
from acf_jax.model import Impact, Rig
from acf_jax.predict import LONGEST
from acf_jax.simulator.through import largest_force_through

Scalar = Float[Array, ""]
FINE = 0.08  # omega h
FEWEST_STEPS, MOST_STEPS = 4, 50_000  # of each of the simulation's parts
MOST_AFTER = 4_000  # steps after the stop; what the energy leaves possible then is added
SETTLED = 25.0  # decay times, after which e^{-25} of a swing is left
AT_ONCE = 1e-3  # of a radian of the fastest motion, in which a robot stops that stops at once


def force_until_rest(
    rig: Rig,
    impact: Impact,
    effects: Sequence[AbstractEffect],
    body: Body,
    ending: Ending,
    fastest: Scalar,
    longest_step: float,
    pull: Scalar | float = 0.0,
    brakes_itself: bool = False,
) -> tuple[Scalar, Bool[Array, ""]]:
    """The largest contact force from first contact until robot and flange are at rest, every further contact included.

    A robot whose braking is not stated keeps its speed and stops at once. The flange goes on by itself: without
    effects it is followed until its energy allows no larger force, otherwise as long as `_rest` says.
    A parabola through three samples misses a maximum by |F_C'''| h^3/(9 sqrt 3) at most; that of a force that bends
    with (omega + d/m)^3 is added.

    **Arguments:** `rig`: against the body, whose recoil is simulated. `fastest`: rate of its motion, 1/s. `pull`: 1
    where a contact holds and pulls until the robot has stopped. `brakes_itself`: one of the effects stops the robot.

    **Returns:** N, and whether it could be followed.
    """
    rate = fastest + rig.d / rig.m
    step = jnp.minimum(longest_step, FINE / rate)
    v_e, stop = impact.v_e, stopping_time(ending, impact.v_e)
    is_told, is_clamped = jnp.isfinite(stop) | (v_e == 0), jnp.asarray(body.mobility) == 0
    begin, deceleration = braking(ending, v_e, jax.lax.stop_gradient(AT_ONCE / rate))
    begin, stopped = (jnp.where(jnp.isfinite(t), t, LONGEST) for t in (begin, begin + v_e / deceleration))
    corners = jnp.stack([begin, stopped, stopped + (_rest(rig) if effects else MOST_AFTER * step)])
    # what has settled is carried along, and its stop presses less than `carried_force`: the actuator's push
    # d v + k_F v t stops growing, which overshoots by k_F v/omega at most
    settled = jnp.where(is_clamped & (not effects), _settled(rig), jnp.inf)
    corners = jnp.where(settled < begin, settled, corners)
    spans = jnp.diff(corners, prepend=0.0)
    needed = jax.lax.stop_gradient(jnp.ceil(spans / step - 1e-6))
    can_be_followed = (needed <= MOST_STEPS).all()
    steps = jnp.where(can_be_followed & (needed > 0), jnp.maximum(needed, FEWEST_STEPS), 0).astype(int)

    def later(motion: Motion) -> Scalar:
        return _energy_bound(motion, body.mobility)

    force = largest_force_through(
        rig,
        impact,
        [
            *effects,
            Recoil(jnp.asarray(body.mobility)),
            *([] if brakes_itself else [Braking(deceleration, begin)]),
        ],
        corners,
        steps,
        pull,
        None if effects else later,
    )
    between = 1 + jax.lax.stop_gradient(step * rate) ** 3 / (9 * 3**0.5)
    return force * between, jnp.isfinite(force) & is_told & can_be_followed


def _energy_bound(motion: Motion, mobility: Scalar | float) -> Scalar:
    """What the force does not exceed from now on, N, where the robot is at rest and a contact does not pull.

    W = m q'^2/2 + F_C^2/(2 k_C) + k_F x^2/2 of a flange at q obeys W' = -d q'^2 - F_C y'. The body's y' only grows, so
    that W falls, if y' < 0 with the body's own energy; at the largest force q' = y'. Clamped, x + F_C/k_C is constant,
    and W is a quadratic in F_C.
    """
    rig = motion.rig
    q_dot = -motion.x_dot
    y_dot = q_dot - motion.s_dot
    twice = rig.m * q_dot**2 + motion.f_c**2 / rig.k_c + rig.k_f * motion.x**2
    is_clamped = jnp.asarray(mobility) == 0
    of_body = jnp.where(y_dot < 0, 1 / jnp.where(is_clamped, 1.0, mobility), -rig.m) * y_dot**2
    length = motion.x + motion.s + motion.f_0 / rig.k_c
    clamped = rig.k * twice - rig.k_f * rig.k_c * length**2
    root = _root(jnp.where(is_clamped, clamped, rig.k_c * (twice + of_body)))
    return jnp.where(is_clamped, rig.k_c * (rig.k_f * length + root) / rig.k, root)


def _root(x: Scalar) -> Scalar:
    """sqrt(x), zero below zero, with derivatives everywhere."""
    return jnp.where(x > 0, jnp.sqrt(jnp.where(x > 0, x, 1.0)), 0.0)


def _settled(rig: Rig) -> Scalar:
    """When what the first contact set swinging is gone, s. Infinite without damping.

    The slowest decay is that of a flange without contact, delta - sqrt(delta^2 - k_F/m).
    """
    delta, spring = rig.delta, rig.k_f / rig.m
    beyond = delta**2 - spring
    fast = delta + _root(beyond)
    return _over(SETTLED, jnp.where(beyond > 0, spring / fast, delta))


def _rest(rig: Rig) -> Scalar:
    """How long a flange with effects is followed after the stop, s: a period of the contact, and a flight.

    A flange that was thrown off comes back within half a period of its own; where damping makes that longer, 6 m/d is
    enough for all of the flight but a creeping return.
    """
    flight = jnp.minimum(jnp.pi * _over(1.0, jnp.sqrt(rig.k_f / rig.m)), _over(3.0, rig.delta))
    return 2 * jnp.pi / rig.omega + jnp.where(rig.k_f > 0, flight, 0.0)


def _over(share: float, rate: Scalar) -> Scalar:
    """share/rate, infinite for a rate of zero."""
    return jnp.where(rate > 0, share / jnp.where(rate > 0, rate, 1.0), jnp.inf)

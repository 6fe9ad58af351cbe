"""The largest contact force of one impact over a whole window: contact may be lost and made again in it."""

from collections.abc import Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from acf_jax.effects import AbstractEffect
from acf_jax.effects._interface import Scalar
from acf_jax.model import Impact, Rig
from acf_jax.simulator.simulate import State, System, at_rest, make_system


class _Passed(NamedTuple):
    """What the loop remembers."""

    y: State
    released: Bool[Array, ""]
    last: tuple[Scalar, Scalar]  # N, the force one step ago and now
    largest: Scalar  # N


def largest_force_through(
    rig: Rig,
    impact: Impact,
    effects: Sequence[AbstractEffect],
    corners: Float[Array, " parts"],
    steps: Int[Array, " parts"],
    pull: Scalar | float = 0.0,
) -> Float[Array, ""]:
    """The largest contact force from first contact until the last of the corners, its end included.

    Parabolas through three samples tell what lies between them. The step in which contact is lost or made is divided
    there: the method keeps its order across the corner of the contact's law.

    **Arguments:** `rig`, `impact`, `effects`, `pull` as for `simulate`, one sample. `corners`: s, increasing; between
    them everything that depends on time is smooth. `steps`: of equal size, from one corner to the next.

    **Returns:** N, scalar; derivatives in forward mode.
    """
    system = make_system(rig, impact, effects, pull)
    begins = jnp.concatenate([jnp.zeros(1), corners[:-1]])
    sizes = (corners - begins) / jnp.maximum(steps, 1)
    last_step = jnp.cumsum(steps)

    def body(k: Int[Array, ""], passed: _Passed) -> _Passed:
        part = (k >= last_step).sum()
        since = k - (last_step[part] - steps[part])
        t, h = begins[part] + since * sizes[part], sizes[part]
        y, released = _advance(system, t, h, passed.y, passed.released)
        left, mid = passed.last
        right = system.motion(t + h, y).f_c
        curvature = left - 2 * mid + right
        is_bent = (since > 0) & (curvature < 0)
        shift = 0.5 * (left - right) / jnp.where(is_bent, curvature, -1.0)
        top = mid - jnp.where(is_bent & (jnp.abs(shift) <= 1), 0.25 * (left - right) * shift, 0.0)
        return _Passed(y, released, (mid, right), jnp.maximum(passed.largest, jnp.maximum(top, right)))

    y_0 = at_rest(system.effects)
    f_0 = system.motion(jnp.zeros(()), y_0).f_c
    first = _Passed(y_0, jnp.asarray(False), (f_0, f_0), f_0)
    largest: Scalar = jax.lax.fori_loop(0, last_step[-1], body, first).largest
    return largest


def _advance(
    system: System, t: Scalar, h: Scalar, y: State, released: Bool[Array, ""]
) -> tuple[State, Bool[Array, ""]]:
    """One step, in two where the contact's force changes its sign within it."""
    free = jnp.where(released, 1.0, system.free_share(t, h, y))
    whole = system.step(t, h, y, free)
    law = system._replace(pull=jnp.asarray(1.0))
    before, after = law.motion(t, y).f_c, law.motion(t + h, whole).f_c
    is_corner = before * after < 0
    until = jnp.where(is_corner, before / jnp.where(is_corner, before - after, 1.0), 1.0) * h
    on = jnp.asarray(1.0)
    there = system.step(t, until, y, on)
    divided = system.step(t + until, h - until, there, on)
    y = jax.tree.map(lambda a, b: jnp.where(is_corner & (free == 1), b, a), whole, divided)
    return y, released | (free > 0)

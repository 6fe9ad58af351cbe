"""The largest contact force of one impact over a whole window: contact may be lost and made again in it."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from acf_jax.effects import AbstractEffect, Motion
from acf_jax.effects._interface import Scalar
from acf_jax.model import Impact, Rig
from acf_jax.simulator.simulate import State, System, at_rest, make_system

Later = Callable[[Motion], Scalar]
ENOUGH = (
    1 + 2e-5
)  # a bound so little above the largest force ends a simulation: undamped, no bound falls below it


class _Passed(NamedTuple):
    """What the loop remembers."""

    k: Int[Array, ""]  # steps taken
    y: State
    released: Bool[Array, ""]
    last: tuple[Scalar, Scalar]  # N, the force one step ago and now
    largest: Scalar  # N
    later: tuple[Scalar, Scalar]  # N, what no force after one step ago exceeds, and none from now on


def largest_force_through(
    rig: Rig,
    impact: Impact,
    effects: Sequence[AbstractEffect],
    corners: Float[Array, " parts"],
    steps: Int[Array, " parts"],
    pull: Scalar | float = 0.0,
    later: Later | None = None,
) -> Float[Array, ""]:
    """The largest contact force from first contact until the last of the corners, its end included.

    Parabolas through three samples tell what lies between them. The step in which contact is lost or made is divided
    there: the method keeps its order across the corner of the contact's law.

    **Arguments:** `rig`, `impact`, `effects` as for `simulate`, one sample. `corners`: s, increasing; between
    them everything that depends on time is smooth. `steps`: of equal size, from one corner to the next. `pull` as for
    `simulate`; in the last part a contact does not pull. `later`: what in the last part no later force exceeds, N; the
    part ends as soon as that is no more than the largest force so far, up to rounding, and this bound counts, too.

    **Returns:** N, scalar; derivatives in forward mode.
    """
    system = make_system(rig, impact, effects, pull)
    begins = jnp.concatenate([jnp.zeros(1), corners[:-1]])
    sizes = (corners - begins) / jnp.maximum(steps, 1)
    last_step = jnp.cumsum(steps)

    def goes_on(passed: _Passed) -> Bool[Array, ""]:
        return (passed.k < last_step[-1]) & (passed.later[0] > ENOUGH * passed.largest)

    def body(passed: _Passed) -> _Passed:
        k = passed.k
        part = (k >= last_step).sum()
        since = k - (last_step[part] - steps[part])
        t, h = begins[part] + since * sizes[part], sizes[part]
        is_last = k >= last_step[-2]
        law = system._replace(pull=jnp.where(is_last, 0.0, system.pull))
        y, released = _advance(law, t, h, passed.y, passed.released)
        left, mid = passed.last
        motion = law.motion(t + h, y)
        right = motion.f_c
        curvature = left - 2 * mid + right
        is_bent = (since > 0) & (curvature < 0)
        shift = 0.5 * (left - right) / jnp.where(is_bent, curvature, -1.0)
        top = mid - jnp.where(is_bent & (jnp.abs(shift) <= 1), 0.25 * (left - right) * shift, 0.0)
        largest = jnp.maximum(passed.largest, jnp.maximum(top, right))
        unknown = jnp.asarray(jnp.inf)
        now = unknown if later is None else jnp.where(is_last, later(motion), unknown)
        return _Passed(k + 1, y, released, (mid, right), largest, (passed.later[1], now))

    y_0 = at_rest(system.effects)
    f_0 = system.motion(jnp.zeros(()), y_0).f_c
    first = _Passed(jnp.asarray(0), y_0, jnp.asarray(False), (f_0, f_0), f_0, (jnp.asarray(jnp.inf),) * 2)
    passed: _Passed = jax.lax.while_loop(goes_on, body, first)
    is_bounded = jnp.isfinite(passed.later[0])
    return jnp.maximum(passed.largest, jnp.where(is_bounded, passed.later[0], 0.0))


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

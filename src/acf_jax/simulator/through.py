"""The largest contact force of one impact over a whole window: contact may be lost and made again in it."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from acf_jax.effects import AbstractEffect, Motion
from acf_jax.effects._interface import Scalar
from acf_jax.model import Impact, Rig
from acf_jax.simulator.simulate import State, at_rest, make_system

Later = Callable[[Motion], Scalar]
LEAST_SHARE = 1e-6  # of a step, on either side of a corner
ENOUGH = (
    1 + 2e-5
)  # a bound so little above the largest force ends a simulation: undamped, no bound falls below it


class _Passed(NamedTuple):
    """What the loop remembers."""

    k: Int[Array, ""]  # steps taken
    begun: Scalar  # share of the next one that is done, and up to which it is tried
    aim: Scalar
    y: State
    two_sided: Scalar  # N, the force now by the law that pulls
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

    Parabolas through three samples tell what lies between them. The step in which contact is lost or made is taken
    again, divided there: the method keeps its order across the corner of the contact's law.

    **Arguments:** `rig`, `impact`, `effects` as for `simulate`, one sample. `corners`: s, increasing; between
    them everything that depends on time is smooth. `steps`: of equal size, from one corner to the next. `pull` as for
    `simulate`; in the last part a contact does not pull. `later`: what in the last part no later force exceeds, N; the
    part ends as soon as that is no more than the largest force so far, up to rounding, and this bound counts, too.

    **Returns:** N, scalar; derivatives in forward mode.
    """
    system = make_system(rig, impact, effects, pull)
    pulling = system._replace(pull=jnp.asarray(1.0))
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
        at, size = t + passed.begun * h, (passed.aim - passed.begun) * h
        free = jnp.where(passed.released, 1.0, law.free_share(at, size, passed.y))
        y = law.step(at, size, passed.y, free)
        motion = pulling.motion(at + size, y)
        is_corner = (
            (passed.begun == 0) & (passed.aim == 1) & (free == 1) & (passed.two_sided * motion.f_c < 0)
        )
        corner = passed.two_sided / jnp.where(is_corner, passed.two_sided - motion.f_c, 1.0)
        again = passed._replace(aim=jnp.clip(corner, LEAST_SHARE, 1 - LEAST_SHARE))

        is_whole = passed.aim == 1
        right = jnp.where(motion.f_c > 0, motion.f_c, law.pull * motion.f_c)
        left, mid = passed.last
        curvature = left - 2 * mid + right
        is_bent = (since > 0) & is_whole & (curvature < 0)
        shift = 0.5 * (left - right) / jnp.where(is_bent, curvature, -1.0)
        top = mid - jnp.where(is_bent & (jnp.abs(shift) <= 1), 0.25 * (left - right) * shift, 0.0)
        unknown = jnp.asarray(jnp.inf)
        now = unknown if later is None else jnp.where(is_last, later(motion._replace(f_c=right)), unknown)
        there = _Passed(
            k + is_whole,
            jnp.where(is_whole, 0.0, passed.aim),
            jnp.asarray(1.0),
            y,
            motion.f_c,
            passed.released | (free > 0),
            jax.tree.map(lambda a, b: jnp.where(is_whole, a, b), (mid, right), passed.last),
            jnp.maximum(passed.largest, jnp.maximum(top, right)),
            jax.tree.map(lambda a, b: jnp.where(is_whole, a, b), (passed.later[1], now), passed.later),
        )
        return jax.tree.map(lambda a, b: jnp.where(is_corner, a, b), again, there)

    zero, one, unknown = (jnp.asarray(x) for x in (0.0, 1.0, jnp.inf))
    f_0 = pulling.motion(zero, at_rest(system.effects)).f_c  # positive
    first = _Passed(
        jnp.asarray(0),
        zero,
        one,
        at_rest(system.effects),
        f_0,
        jnp.asarray(False),
        (f_0, f_0),
        f_0,
        (unknown,) * 2,
    )
    passed: _Passed = jax.lax.while_loop(goes_on, body, first)
    is_bounded = jnp.isfinite(passed.later[0])
    return jnp.maximum(passed.largest, jnp.where(is_bounded, passed.later[0], 0.0))

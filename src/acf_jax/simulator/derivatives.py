"""Many impacts at once with the derivatives of their forces: forward mode, written into the loop.

Equal to `jax.jvp` of `simulate`, mapped over directions and impacts. But JAX transforms a loop by tracing its body
again and again, for each transformation and each guess of what depends on what; here the body is traced once.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from acf_jax.effects._interface import Scalar
from acf_jax.simulator.simulate import Moving, System, advance, start

Released = Bool[Array, ""]
Smooth = Any  # the parts of `Moving` that have derivatives: state, signals and memories
Tangent = tuple[Smooth, Smooth, Released]  # the parts, their derivatives in each direction, and what has none


def simulate_with_derivatives(
    make: Callable[..., System],
    z: Float[Array, "n p"],
    h: Scalar,
    samples: int,
    steps: Int[Array, ""],
    data: Any = (),
) -> tuple[Float[Array, "samples n"], Float[Array, "samples p+1 n"]]:
    """Forces of `n` impacts on the grid 0, h, 2h, ...

    **Arguments:** `make`: the equations of motion of one impact from its numbers, and from its data where there are
    any. `z`: these numbers. `h`, `samples`, `steps`: as for `simulate`. `data`: arrays whose last axis is that of the
    impacts, in which nothing is derived.

    **Returns:** the contact forces in N; the sensed forces in N, followed by their derivatives in each of the numbers.
    """
    # impacts stand last everywhere: neighbours in memory take the same operation
    z = z.T
    p, n = z.shape
    directions = jnp.broadcast_to(jnp.eye(p)[:, :, None], (p, p, n))

    def begin(z: Float[Array, " p"], *data: Any) -> tuple[Smooth, Released]:
        return _split(start(make(z, *data), h))

    def onward(
        z: Float[Array, " p"], smooth: Smooth, released: Released, *data: Any, k: Int[Array, ""]
    ) -> tuple[Smooth, Released]:
        y, signals, memories = smooth
        return _split(advance(make(z, *data), k, h, Moving(y, released, signals, memories)))

    def first(direction: Float[Array, "p n"]) -> Tangent:
        step = jax.vmap(begin, in_axes=-1, out_axes=-1)
        return jax.jvp(lambda z: step(z, *data), (z,), (direction,), has_aux=True)

    def after(moving: Tangent, k: Int[Array, ""]) -> Tangent:
        smooth, tangents, released = moving
        step = jax.vmap(partial(onward, k=k), in_axes=-1, out_axes=-1)

        def along(direction: Float[Array, "p n"], tangent: Smooth) -> Tangent:
            return jax.jvp(
                lambda z, smooth: step(z, smooth, released, *data),
                (z, smooth),
                (direction, tangent),
                has_aux=True,
            )

        return jax.vmap(along, out_axes=(None, 0, None))(directions, tangents)

    def forces(moving: Tangent) -> tuple[Float[Array, " n"], Float[Array, "p+1 n"]]:
        (_, signals, _), (_, tangents, _), _ = moving
        return signals[0], jnp.concatenate([signals[-1][None], tangents[-1]])

    def body(k: Int[Array, ""], carry: Any) -> Any:
        moving, contact, rows = carry
        moving = after(moving, k)
        now = forces(moving)
        return moving, contact.at[k + 1].set(now[0]), rows.at[k + 1].set(now[1])

    moving_0 = jax.vmap(first, out_axes=(None, 0, None))(directions)
    now = forces(moving_0)
    contact = jnp.zeros((samples, n)).at[0].set(now[0])
    rows = jnp.zeros((samples, p + 1, n)).at[0].set(now[1])
    _, contact, rows = jax.lax.fori_loop(0, steps, body, (moving_0, contact, rows))
    return contact, rows


def _split(moving: Moving) -> tuple[Smooth, Released]:
    return (moving.y, moving.signals, moving.memories), moving.released

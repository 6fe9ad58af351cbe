"""Mapping one-sample functions over large batches in blocks that stay in a core's cache."""

from collections.abc import Callable
from typing import TypeVar

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, PyTree

# Two dozen float64 intermediates of this many samples fit the second-level cache of one core.
BLOCK = 4096

Out = TypeVar("Out", bound=PyTree[Array])


def in_blocks(fn: Callable[..., Out]) -> Callable[..., Out]:
    """`jax.vmap(fn)` over the leading axis, computed `BLOCK` samples at a time.

    The last block overlaps the one before it: no padding and no copy of the inputs, which for a million
    samples would cost as much time as the peak force itself.
    """
    mapped = jax.vmap(fn)

    def blocked(*args: PyTree[Array]) -> Out:
        size = jax.tree.leaves(args)[0].shape[0]
        if size <= BLOCK:
            return mapped(*args)
        out = jax.tree.map(lambda s: jnp.zeros(s.shape, s.dtype), jax.eval_shape(mapped, *args))

        def fill(block: Array, out: Out) -> Out:
            start = jnp.minimum(block * BLOCK, size - BLOCK)
            samples = jax.tree.map(lambda x: lax.dynamic_slice_in_dim(x, start, BLOCK), args)
            return jax.tree.map(
                lambda whole, part: lax.dynamic_update_slice_in_dim(whole, part, start, 0),
                out,
                mapped(*samples),
            )

        return lax.fori_loop(0, -(-size // BLOCK), fill, out)

    return blocked

"""How a free curve goes on beyond what it was fitted to."""

from collections.abc import Callable, Sequence

import jax.numpy as jnp

from acf_jax.effects._interface import Scalar


def continued(
    curve: Callable[[Scalar], Scalar], u: Scalar, reach: Scalar, over: Sequence[float], steepest: float
) -> Scalar:
    """A free curve g(u), straight above the reach: a polynomial beyond what it was fitted to says nothing.

    The slope is the least of the mean ones `over` these last shares of the tried range, within -1 (u + g(u) does not
    fall) and `steepest`.
    """
    tried = jnp.minimum(u, reach)
    end = jnp.where(jnp.isfinite(reach), reach, 1.0)
    slopes = jnp.stack([(curve(end) - curve((1 - share) * end)) / (share * end) for share in over])
    return curve(tried) + jnp.clip(slopes.min(), -1.0, steepest) * (u - tried)

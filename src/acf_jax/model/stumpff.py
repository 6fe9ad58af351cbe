"""Damped Stumpff functions: one formula for under-, critically and overdamped motion."""

from functools import partial
from math import factorial

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

# The series serves |z| up to this: below it the recurrence would cancel, above it the series would.
_SERIES_RANGE = 8.0
_SERIES_TERMS = 16


def stumpff_series(k: int, z: Array, terms: int) -> Array:
    """c_k(z) = sum_j (-z)^j/(2 j + k)!, its first `terms` terms by Horner's rule."""
    total = jnp.full_like(z, 1 / factorial(2 * (terms - 1) + k))
    for j in reversed(range(terms - 1)):
        total = 1 / factorial(2 * j + k) - z * total
    return total


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def damped_stumpff(k: int, alpha: Float[Array, ""], z: Float[Array, ""]) -> Float[Array, ""]:
    """D_k(alpha, z) = e^{-alpha} c_k(z), with Stumpff's c_0 = cos(sqrt z), c_1 = sin(sqrt z)/sqrt z, ...

    With alpha = delta t and z = (omega^2 - delta^2) t^2 these are e^{-delta t} cos(nu t) and
    e^{-delta t} sin(nu t)/(nu t) at every damping: c_k is entire, so critical damping (z = 0) is no
    special case, and the exponentials are joined before they can overflow (z < 0).

    **Arguments:** `k` order, 0, 1, 2, ...; `alpha` decay, at least sqrt(-z) where z < 0; `z` argument.

    **Returns:** D_k, derivatives of all orders from dc_k/dz = (k c_{k+2} - c_{k+1})/2.

    **Source:** K. Stumpff, Himmelsmechanik I (1959); Danby, Fundamentals of Celestial Mechanics, 6.9.
    """
    near = jnp.abs(z) < _SERIES_RANGE
    series = jnp.exp(-alpha) * stumpff_series(k, jnp.where(near, z, 0.0), _SERIES_TERMS)
    z = jnp.where(near, _SERIES_RANGE, z)
    x = jnp.sqrt(jnp.abs(z))
    slow, fast = jnp.exp(jnp.minimum(x - alpha, 0.0)), jnp.exp(-x - alpha)
    decay = jnp.exp(-alpha)
    if k % 2:
        far = jnp.where(z > 0, decay * jnp.sin(x), (slow - fast) / 2) / x
    else:
        far = jnp.where(z > 0, decay * jnp.cos(x), (slow + fast) / 2)
    for j in range(k % 2, k, 2):
        far = (decay / factorial(j) - far) / z
    return jnp.where(near, series, far)


@damped_stumpff.defjvp
def _damped_stumpff_jvp(
    k: int, primals: tuple[Array, Array], tangents: tuple[Array, Array]
) -> tuple[Array, Array]:
    (alpha, z), (alpha_dot, z_dot) = primals, tangents
    value = damped_stumpff(k, alpha, z)
    slope = (k * damped_stumpff(k + 2, alpha, z) if k else 0.0) - damped_stumpff(k + 1, alpha, z)
    return value, slope / 2 * z_dot - value * alpha_dot

"""Carlson's elementary integral R_C: arc tangent and inverse hyperbolic tangent in one function."""

import jax.numpy as jnp
from jaxtyping import Array, Float

_DUPLICATIONS = 4
_TERMS = 11


def carlson_rc(g: Float[Array, ""], h: Float[Array, ""]) -> Float[Array, ""]:
    """R_C(g^2, h^2) = atan(sqrt(h^2 - g^2)/g)/sqrt(h^2 - g^2), and its continuation to h < g.

    Duplication in square roots is Borchardt's mean, g <- (g + h)/2, h <- sqrt(g h): one square root a
    step, no division, and no trigonometric function, which XLA evaluates slowly in float64. A last step needs no
    root: R_C(g^2, h^2) = 2/(g + h) R_C(1, 1 + t), t = (h - g)/(h + g), whose series is that of the arc tangent.

    **Arguments:** `g` >= 0 and `h` > 0, the square roots of Carlson's two arguments.

    **Returns:** R_C, to a few units in the last place for h/g > 1e-3.

    **Source:** DLMF 19.2.17 and 19.26.26 (duplication).
    """
    for _ in range(_DUPLICATIONS):
        g = (g + h) / 2
        h = jnp.sqrt(g * h)
    per_sum = 1 / (g + h)
    t = (h - g) * per_sum
    series = jnp.full_like(t, 1 / (2 * _TERMS - 1))
    for k in reversed(range(_TERMS - 1)):
        series = 1 / (2 * k + 1) - t * series
    return 2 * per_sum * series

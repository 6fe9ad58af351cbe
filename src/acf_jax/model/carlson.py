"""Carlson's elementary integral R_C: arc tangent and inverse hyperbolic tangent in one function."""

import jax.numpy as jnp
from jaxtyping import Array, Float

_DUPLICATIONS = 5


def carlson_rc(g: Float[Array, ""], h: Float[Array, ""]) -> Float[Array, ""]:
    """R_C(g^2, h^2) = atan(sqrt(h^2 - g^2)/g)/sqrt(h^2 - g^2), and its continuation to h < g.

    Duplication in square roots is Borchardt's mean, g <- (g + h)/2, h <- sqrt(g h): one square root a
    step, no division, and no trigonometric function, which XLA evaluates slowly in float64.

    **Arguments:** `g` >= 0 and `h` > 0, the square roots of Carlson's two arguments.

    **Returns:** R_C, to a few units in the last place for h/g > 1e-3.

    **Source:** DLMF 19.2.17, 19.26.26 (duplication) and 19.36.1 (series).
    """
    for _ in range(_DUPLICATIONS):
        g = (g + h) / 2
        h = jnp.sqrt(g * h)
    mean = (g * g + 2 * h * h) / 3
    s = (h * h - mean) / mean
    series = 1 + s * s * (3 / 10 + s * (1 / 7 + s * (3 / 8 + s * (9 / 22 + s * (159 / 208 + s * 9 / 8)))))
    return series / jnp.sqrt(mean)

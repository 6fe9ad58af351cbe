"""dF_C/dt = 0 in its shortest form, s(sigma) = r, and its root.

s(sigma) = e^{-zeta sigma} sin(eta sigma)/eta,  eta^2 = 1 - zeta^2

rises from 0, concave, to its maximum r_m at sigma_m: it crosses r <= r_m once in [0, sigma_m].
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PyTree

from acf_jax.model.stumpff import stumpff_series

Scalar = Float[Array, ""]

# Reached by no sample below zeta = 1e6; a bound all the same.
MAX_STEPS = 64


class Crossing(NamedTuple):
    """The equation s(sigma) = r of one sample."""

    zeta: Scalar
    eta_squared: Scalar
    sigma_m: Scalar  # where s is largest
    r_m: Scalar  # s(sigma_m)
    ratio: Scalar  # r/r_m, in [0, 1]


def _swing(zeta: Scalar, eta_squared: Scalar, sigma: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """e^{-zeta sigma}, C(sigma), S(sigma) within the bracket: series at sigma/4, its angle doubled twice."""
    z = eta_squared * sigma * sigma / 16
    sine, cosine = stumpff_series(1, z, 9), 1 - z * stumpff_series(2, z, 9)
    for _ in range(2):
        sine, cosine, z = sine * cosine, 1 - 2 * z * sine * sine, 4 * z
    return jnp.exp(-zeta * sigma), cosine, sigma * sine


def residual(sigma: Scalar, crossing: PyTree) -> tuple[Scalar, tuple[Scalar, Scalar]]:
    """s(sigma) - r with its first two derivatives; the second follows from s'' + 2 zeta s' + s = 0."""
    decay, cosine, sine = _swing(crossing.zeta, crossing.eta_squared, sigma)
    s, slope = decay * sine, decay * (cosine - crossing.zeta * sine)
    return s - crossing.ratio * crossing.r_m, (slope, -2 * crossing.zeta * slope - s)


def _guess(crossing: Crossing) -> Scalar:
    """sigma by a sextic in u = sqrt(1 - r/r_m): exact to third order at the fold, to second at r = 0.

    Far into overdamping s has a boundary layer that no sextic follows: there the lower bound r, from which
    a concave increasing function is climbed without fail.
    """
    zeta, r_m = crossing.zeta, crossing.r_m
    root_2 = np.sqrt(2).astype(zeta.dtype)
    c_2, c_3 = -2 / 3 * zeta, (1 / 6 + 4 / 9 * zeta * zeta) / root_2
    value = crossing.sigma_m - (root_2 + c_2 + c_3)
    slope = 2 * r_m - (root_2 + 2 * c_2 + 3 * c_3)
    curvature = 2 * r_m - 8 * zeta * r_m * r_m - (2 * c_2 + 6 * c_3)
    c_6 = curvature / 2 - 4 * slope + 10 * value
    c_5 = slope - 4 * value - 2 * c_6
    c_4 = value - c_5 - c_6
    u = jnp.sqrt(1 - crossing.ratio)
    below = u * (root_2 + u * (c_2 + u * (c_3 + u * (c_4 + u * (c_5 + u * c_6)))))
    sextic = jnp.clip(crossing.sigma_m - below, 0.0, crossing.sigma_m)
    return jnp.where(zeta < 3, sextic, crossing.ratio * r_m)


def halley_step(
    y: Scalar, derivatives: tuple[Scalar, Scalar, Scalar], lower: Scalar, upper: Scalar
) -> Scalar:
    """Halley's y - 2 f f'/(2 f'^2 - f f''), moved back into [lower, upper]; y itself where the step has no meaning."""
    f, slope, curvature = derivatives
    denominator = slope * slope - f * curvature / 2
    sound = denominator > 0
    step = f * slope / jnp.where(sound, denominator, 1.0)
    return jnp.clip(jnp.where(sound, y - step, y), lower, upper)


def next_step(step: Scalar, width: Scalar) -> Scalar:
    """The size expected of the step after `step`: its cube, in units of the bracket's width."""
    return step * (step / width) ** 2


def half_the_digits(crossing: Crossing) -> float:
    """The tolerance of a root: F_max is stationary there, and `polish` brings t_max the other half."""
    return float(jnp.finfo(crossing.zeta.dtype).eps) ** 0.5


def first_step(crossing: Crossing) -> tuple[Scalar, Scalar]:
    """sigma after one step from the guess, and the size of that step, which suffices for zeta < 2.9.

    As straight-line code before the loop, which a batch then leaves without a turn: its turns cost more than steps.
    """
    return _step(_guess(crossing), crossing)


def _step(sigma: Scalar, crossing: Crossing) -> tuple[Scalar, Scalar]:
    new_sigma = polish(sigma, residual(sigma, crossing), crossing)
    return new_sigma, jnp.abs(new_sigma - sigma)


def find_crossings(crossing: Crossing) -> Scalar:
    """The iteration of `halley.find_crossing` without optimistix, for batches."""
    width, tolerance = crossing.sigma_m, half_the_digits(crossing)

    def is_rough(state: tuple[Scalar, Scalar, Array]) -> Array:
        _, last_step, steps = state
        # false for NaN, so that a sample that is not a number does not hold up its block
        return (next_step(last_step, width) > tolerance * width) & (steps < MAX_STEPS)

    def turn(state: tuple[Scalar, Scalar, Array]) -> tuple[Scalar, Scalar, Array]:
        sigma, _, steps = state
        return *_step(sigma, crossing), steps + 1

    return jax.lax.while_loop(is_rough, turn, (*first_step(crossing), jnp.asarray(1)))[0]


def polish(sigma: Scalar, at_sigma: tuple[Scalar, tuple[Scalar, Scalar]], crossing: Crossing) -> Scalar:
    """One Halley step from sigma, where `residual` is already known."""
    f, (slope, curvature) = at_sigma
    return halley_step(sigma, (f, slope, curvature), jnp.zeros_like(sigma), crossing.sigma_m)

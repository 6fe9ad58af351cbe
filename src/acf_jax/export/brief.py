"""A surrogate of the paper's model by few operations, for runtimes to which an operation costs more than its numbers.

With D = 2 zeta, everything that `distance_to_fold` computes by square roots alone is a polynomial of one number here:

    R_C(a^2, Q) = 4 R_C(c_2^2, 1)/(sqrt(Q) X_1 X_2),  X_0 = 2 a/sqrt(Q),  X_{n+1} = sqrt(2 + X_n),  c_n = X_n/2,

since X_n = 2 cos(theta/2^n) for cos theta = a/sqrt(Q); for a < 0 as well, so that no half period is added. Times are
counted in -2/omega, which saves factors.
"""

from collections.abc import Callable
from functools import partial

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from acf_jax.model import Impact, Rig
from acf_jax.model.carlson import carlson_rc
from acf_jax.model.stumpff import stumpff_series
from acf_jax.surrogate import Surrogate
from acf_jax.surrogate.box import UNITS, limits
from acf_jax.surrogate.features import FoldFeatures
from acf_jax.surrogate.surrogate import ULPS

Scalar = Float[Array, ""]

ACCURACY = 1e-10  # relative, of each polynomial
MOST_TERMS = 24
LARGEST_RATIO = 1e3  # a/sqrt(Q), to which carlson_rc is right
TERMS = 16  # of Stumpff's series


def brief(
    surrogate: Surrogate,
) -> Callable[[Float[Array, " 6"]], tuple[Scalar, Scalar, Bool[Array, ""]]] | None:
    """Force, its error bound and whether both hold, of m, d, k_F, k_C, v_E and F_P; infinite where they do not.

    Nothing but the surrogate's own outputs to 1e-6, by a third of the steps. None where its range of the damping
    ratio is too wide for a polynomial.
    """
    _, zeta_high = limits(surrogate.box)[:, tuple(UNITS).index("zeta")]
    is_over = zeta_high >= 1
    largest_angle = np.arccosh(zeta_high) if is_over else 0.0  # of sigma_m, imaginary
    widest = 2 * np.cosh(np.arccosh(LARGEST_RATIO) / 4) if is_over else 2.0
    bracket = _fitted(lambda d: -_rc(d / 2) / 2, 0.0, 2 * zeta_high)
    angle = _fitted(lambda x: -2 * _rc(x / 2), np.sqrt(2), widest)
    ends = -(largest_angle**2), 1.01 * np.pi**2 / 4  # of (eta sigma)^2
    cosine, sine = _fitted(partial(_stumpff, 0), *ends), _fitted(partial(_stumpff, 1), *ends)
    if bracket is None or angle is None or cosine is None or sine is None:
        return None
    terms = max(len(cosine), len(sine))
    both = np.stack([np.pad(series, (0, terms - len(series))) for series in (cosine, sine)])
    low, high = limits(surrogate.box)
    middle, half = (low + high) / 2, np.maximum((high - low) / 2, np.finfo(float).tiny)
    held_out, rounding = surrogate.held_out, ULPS * np.finfo(float).eps
    drops = np.diff(held_out.largest, append=held_out.largest[-1])  # from a bin to the next

    def function(x: Float[Array, " 6"]) -> tuple[Scalar, Scalar, Bool[Array, ""]]:
        m, d, k_f, k_c, v_e, f_p = x
        k = k_f + k_c
        root_mk = jnp.sqrt(m * k)
        momentum, damping, epsilon = v_e * root_mk, d / root_mk, k_f / k  # damping = 2 zeta
        kappa = 1 - epsilon
        kappa_momentum = kappa * momentum
        damped = damping * kappa_momentum
        rest = f_p - damped
        root_q = jnp.sqrt(f_p * rest + kappa_momentum * kappa_momentum)
        x_1 = jnp.sqrt(2 + (f_p + rest) / root_q)  # f_p + rest = 2 a
        x_2 = jnp.sqrt(2 + x_1)
        tau_0 = kappa_momentum * _polynomial(angle, x_2) / (root_q * (x_1 * x_2))
        sigma_m = _polynomial(bracket, damping)

        largest = root_q * jnp.exp(damping * (tau_0 + sigma_m))
        ratio = epsilon * momentum / largest
        u = jnp.sqrt(1 - ratio)
        if isinstance(surrogate.features, FoldFeatures):
            seen = surrogate.x(jnp.array([0.5, 1.0]) * jnp.stack([damping, u]))
            sigma = sigma_m * surrogate.y.inverse(surrogate.network(seen))
            tau = tau_0 + sigma
            cos, sin = _polynomial(both, (4 - damping * damping) * (sigma * sigma))
            swing = root_q * jnp.exp(damping * tau) * (cos - damping * sigma * sin)
            moving = f_p - kappa_momentum * 2 * tau
            force = epsilon * moving + kappa * (damped + swing)
        else:
            force = surrogate.force(Rig(m, d, k_f, k_c), Impact(v_e, f_p))
        # d stands behind zeta, whose range counts
        values = jnp.concatenate([x, damping[None]])
        matrix = np.zeros((6, 7))
        matrix[np.arange(6), [0, 6, 2, 3, 4, 5]] = np.array([1.0, 0.5, 1.0, 1.0, 1.0, 1.0]) / half
        is_inside = (jnp.abs(matrix @ values - middle / half).max() <= 1) & (ratio < 1)
        force = jnp.where(is_inside, force, jnp.inf)
        error = -jnp.asarray(drops) @ (u <= held_out.edges).astype(float) + (held_out.largest[-1] + rounding)
        return force, error * force, is_inside

    return function


def _rc(x: np.ndarray) -> np.ndarray:
    """R_C(x^2, 1)."""
    return np.asarray(carlson_rc(jnp.asarray(x), jnp.ones_like(x)))


def _stumpff(k: int, z: np.ndarray) -> np.ndarray:
    return np.asarray(stumpff_series(k, jnp.asarray(z), TERMS))


def _fitted(function: Callable[[np.ndarray], np.ndarray], low: float, high: float) -> np.ndarray | None:
    """Coefficients of the shortest polynomial that is right within [low, high], from the constant on; None without."""
    x = np.linspace(low, high, 1001)
    exact = function(x)
    for terms in range(2, MOST_TERMS):
        found = np.polynomial.Chebyshev.interpolate(function, terms - 1, [low, high])
        coefficients = found.convert(kind=np.polynomial.Polynomial, domain=[-1, 1], window=[-1, 1]).coef
        off = np.polynomial.polynomial.polyval(x, coefficients) - exact
        if np.abs(off).max() <= ACCURACY * np.abs(exact).max():
            return coefficients
    return None


def _polynomial(coefficients: np.ndarray, x: Scalar) -> Array:
    """All powers at once and a matrix product, two operations, where Horner's rule takes two a term."""
    powers = jnp.power(x, jnp.arange(coefficients.shape[-1], dtype=float))
    return jnp.asarray(coefficients) @ powers

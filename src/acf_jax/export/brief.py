"""A surrogate of the paper's model by few operations, for runtimes to which an operation costs more than its numbers.

With D = 2 zeta and times counted in -2/omega, which saves factors, three things make many operations few:

- Products of powers, D = d/sqrt(m k) and its own powers among them, are one exponential of a matrix times logarithms;
  sums of them are one more matrix product, and so is every function of D, as a polynomial.
- The swing after tau_0 is a polynomial in y = sigma/sigma_m whose coefficients are polynomials in D.
- What `distance_to_fold` computes by square roots alone is a polynomial of one number:

      R_C(a^2, Q) = 4 R_C(c_2^2, 1)/(sqrt(Q) X_1 X_2),  X_0 = 2 a/sqrt(Q),  X_{n+1} = sqrt(2 + X_n),  c_n = X_n/2,

  since X_n = 2 cos(theta/2^n) for cos theta = a/sqrt(Q); for a < 0 as well, so that no half period is added.
"""

from collections.abc import Callable, Mapping
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from acf_jax.model import Impact, Rig
from acf_jax.model.carlson import carlson_rc
from acf_jax.surrogate import Surrogate
from acf_jax.surrogate.box import UNITS, limits
from acf_jax.surrogate.features import FoldFeatures
from acf_jax.surrogate.surrogate import ULPS

Scalar = Float[Array, ""]

ACCURACY = 1e-11  # relative, of each polynomial
MOST_TERMS = 24
LARGEST_RATIO = 1e3  # a/sqrt(Q), to which carlson_rc is right
MOST_SERIES_TERMS = 30  # of the swing in y
TINY = 1e-300  # whose logarithm stands for that of 0

FACTORS = ("m", "d", "k_f", "k_c", "v_e", "f_p", "k")
BASE = {"d": 1.0, "m": -0.5, "k": -0.5}  # D, as exponents of the factors
# The other products of powers; kappa = k_C/k, epsilon = k_F/k, P = m omega v_E.
PRODUCTS: Mapping[str, Mapping[str, float]] = {
    "1": {},
    "sqrt(m k)": {"m": 0.5, "k": 0.5},
    "f_p": {"f_p": 1},
    "f_p^2": {"f_p": 2},
    "kappa": {"k_c": 1, "k": -1},
    "kappa P": {"k_c": 1, "v_e": 1, "m": 0.5, "k": -0.5},
    "(kappa P)^2": {"k_c": 2, "v_e": 2, "m": 1, "k": -1},
    "epsilon P": {"k_f": 1, "v_e": 1, "m": 0.5, "k": -0.5},
    "epsilon (kappa P)^2": {"k_f": 1, "k_c": 2, "v_e": 2, "m": 1, "k": -2},
    "epsilon kappa P": {"k_f": 1, "k_c": 1, "v_e": 1, "m": 0.5, "k": -1.5},
    "kappa D P": {"d": 1, "v_e": 1, "k_c": 1, "k": -1},
    "kappa D P f_p": {"d": 1, "v_e": 1, "k_c": 1, "k": -1, "f_p": 1},
    "kappa^2 D P": {"d": 1, "v_e": 1, "k_c": 2, "k": -2},
    "epsilon f_p": {"k_f": 1, "k": -1, "f_p": 1},
}
TIMES_DAMPING = ("1", "epsilon kappa P")  # also with each power of D
# What is scaled by powers of sqrt(Q). The second and third are D tau_0 and the actuator's share of the force once they
# are multiplied by R_C; the fourth and fifth are r/r_m and the swing's amplitude at sigma_m once they have decayed.
SCALED: tuple[Mapping[str, float], ...] = (
    {"f_p": 2, "kappa D P": -1},  # 2 a
    {"kappa D P": 1},
    {"epsilon (kappa P)^2": -2},
    {"epsilon P": 1},
    {"kappa": 1},
    {"1": 1},
)
POWERS_OF_Q = np.array([-0.5, -0.5, -0.5, -0.5, 0.5, 0.0])
DECAYS = np.array([0.0, 0.0, 0.0, -1.0, 1.0, 0.0])  # powers of e^{-zeta (tau_0 + sigma_m)}
TWO_A, DELAY, PUSHED, RATIO, SWING, ONE = np.eye(len(SCALED))[:, None]  # rows that take one of them


def brief(
    surrogate: Surrogate,
) -> Callable[[Float[Array, " 6"]], tuple[Scalar, Scalar, Bool[Array, ""]]] | None:
    """Force, its error bound and whether both hold, of m, d, k_F, k_C, v_E and F_P; infinite where they do not.

    Nothing but the surrogate's own outputs to 1e-6, by a seventh of the steps. None where its range of the damping
    ratio is too wide for a polynomial.
    """
    _, zeta_high = limits(surrogate.box)[:, tuple(UNITS).index("zeta")]
    widest = 2 * np.cosh(np.arccosh(LARGEST_RATIO) / 4) if zeta_high >= 1 else 2.0
    bracket = _fitted(lambda d: -_rc(d / 2) / 2, 0.0, 2 * zeta_high)
    angle = _fitted(lambda x: -2 * _rc(x / 2), np.sqrt(2), widest)
    swing = _fitted(_swing, 0.0, 2 * zeta_high)
    if bracket is None or angle is None or swing is None:
        return None
    swing = swing[:, : 1 + np.flatnonzero(np.abs(swing).sum(0) > ACCURACY)[-1]]
    low, high = limits(surrogate.box)
    largest, edges = np.asarray(surrogate.held_out.largest), np.asarray(surrogate.held_out.edges)
    drops = np.diff(largest, append=largest[-1])  # from a bin to the next
    rounding = ULPS * np.finfo(float).eps
    first, *others = surrogate.network.layers
    by_fold = isinstance(surrogate.features, FoldFeatures)
    made = _Products(max(bracket.size + 1, len(swing)))

    # Conditions as numbers that are negative or 0 where they hold: each bin of u, both ends of the box, and u > 0.
    bins, ends = edges.size, 2 * len(UNITS)
    of_u = np.array([1.0] * bins + [0.0] * ends + [-1.0])[:, None]
    of_sample = np.concatenate([np.zeros((bins, 6)), np.eye(6), -np.eye(6), np.zeros((1, 6))])
    limit = np.concatenate([-edges, -high, low, [TINY]])
    is_damping = of_sample[:, 1] != 0  # d, whose limits are those of zeta times 2 sqrt(m k)
    of_range = (np.arange(limit.size) >= bins)[None].astype(float)
    smaller = np.pad(-drops, (0, ends + 1))[None]

    parts = {
        "q": made.sums({"f_p^2": 1, "kappa D P f_p": -1, "(kappa P)^2": 1}),
        "scaled": np.concatenate([made.sums(sums) for sums in SCALED]),
        "fading": made.polynomial(DECAYS[:, None] * np.pad(bracket, (1, 0))),  # D sigma_m
        "conditions": made.sums({"1": np.where(is_damping, 0.0, limit), "sqrt(m k)": 2 * limit * is_damping}),
    }
    if by_fold:
        weight, bias = np.asarray(first.weight), np.asarray(first.bias)
        centre, scale = np.asarray(surrogate.x.centre), np.asarray(surrogate.x.scale)
        seen = np.stack([bias - weight @ (centre / scale), weight[:, 0] / (2 * scale[0])], axis=1)
        by_u = weight[:, 1:] / scale[1]
        parts["layer"] = made.polynomial(seen)
        rest = [
            made.sums({"epsilon f_p": 1, "kappa^2 D P": 1}),
            made.polynomial(-2 * bracket[None], "epsilon kappa P"),
        ]
        parts["terms"] = np.concatenate([made.polynomial(swing.T), *rest])
    sums, cuts = np.concatenate(list(parts.values())), np.cumsum([0, *map(len, parts.values())])
    powers_of_y = np.array([*range(len(swing.T)), 0.0, 1.0])
    of_terms = np.where(np.arange(powers_of_y.size) < len(swing.T), SWING.T, ONE.T)

    def function(x: Float[Array, " 6"]) -> tuple[Scalar, Scalar, Bool[Array, ""]]:
        factors = jnp.abs(np.vstack([np.eye(6), [0, 0, 1, 1, 0, 0]]) @ x + TINY)
        all_sums = sums @ jnp.exp(made.exponents @ jnp.log(factors))
        part = {name: all_sums[i:j] for name, i, j in zip(parts, cuts[:-1], cuts[1:], strict=True)}
        scaled = part["scaled"] * jnp.power(part["q"], POWERS_OF_Q)
        x_1 = jnp.sqrt(TWO_A @ scaled + 2)
        powers = jnp.power(2 + x_1, (np.arange(angle.size) - 1) / 2)
        timed = scaled * (angle[None] @ powers / x_1)
        fade = np.outer(DECAYS, DELAY) @ timed + part["fading"]
        faded = scaled * jnp.exp(fade)
        u = jnp.sqrt(-RATIO @ faded + 1)
        if by_fold:
            hidden = surrogate.network.activation(by_u @ u + part["layer"])
            for layer in others[:-1]:
                hidden = surrogate.network.activation(layer(hidden))
            y = surrogate.y.inverse(others[-1].weight @ hidden + others[-1].bias)
            by_scaled = of_terms @ (part["terms"] * jnp.power(y, powers_of_y))
            force = np.ones((1, len(SCALED))) @ (by_scaled * faded) + PUSHED @ timed
        else:
            force = surrogate.force(Rig(*x[:4]), Impact(*x[4:]))
        holds = (of_u @ u + (of_sample @ x + part["conditions"]) <= 0).astype(float)  # 0 where u is NaN
        is_inside: Bool[Array, ""] = (of_range @ holds > ends + 0.5).reshape(())
        error = (smaller @ holds + (largest[-1] + rounding)).reshape(())
        force = jnp.where(is_inside, force.reshape(()), jnp.inf)
        return force, error * force, is_inside

    return function


class _Products:
    """Products of powers of the factors, `PRODUCTS` and some of them times D^0, D^1, ...; and sums of them as rows."""

    def __init__(self, powers: int):
        self.powers = powers
        columns = np.array([[p.get(name, 0.0) for name in FACTORS] for p in (BASE, *PRODUCTS.values())])
        by_damping = np.arange(powers)[:, None] * columns[0]
        self.exponents = np.concatenate(
            [columns[1:], *(by_damping + columns[1 + list(PRODUCTS).index(name)] for name in TIMES_DAMPING)]
        )

    def sums(self, factors: Mapping[str, Any]) -> np.ndarray:
        """Sums of products, one a row of the factors."""
        rows = max(np.size(factor) for factor in factors.values())
        columns = np.stack([np.broadcast_to(factors.get(name, 0.0), rows) for name in PRODUCTS], axis=1)
        return np.pad(columns, ((0, 0), (0, len(self.exponents) - len(PRODUCTS))))

    def polynomial(self, coefficients: np.ndarray, times: str = "1") -> np.ndarray:
        """Polynomials in D times a product, one a row of their coefficients, from the constant on."""
        start = len(PRODUCTS) + self.powers * TIMES_DAMPING.index(times)
        powers = coefficients.shape[1]
        return np.pad(coefficients, ((0, 0), (start, len(self.exponents) - start - powers)))


def _rc(x: np.ndarray) -> np.ndarray:
    """R_C(x^2, 1)."""
    return np.asarray(carlson_rc(jnp.asarray(x), jnp.ones_like(x)))


def _swing(damping: np.ndarray) -> np.ndarray:
    """Coefficients of the powers of y in the swing since tau_0 over that at sigma_m, a column each.

    h = e^{-zeta sigma} (cos(eta sigma) + zeta sin(eta sigma)/eta) solves h'' + 2 zeta h' + h = 0, which gives its
    series in sigma = y sigma_m; it is divided by e^{-zeta sigma_m}.
    """
    sigma_m = _rc(damping / 2)
    h = [np.ones_like(damping), np.zeros_like(damping)]
    for k in range(MOST_SERIES_TERMS - 2):
        h.append(-(damping * (k + 1) * h[k + 1] + h[k]) / ((k + 1) * (k + 2)))
    scale = np.exp(damping / 2 * sigma_m)
    return np.stack([scale * c * sigma_m**k for k, c in enumerate(h)], axis=-1)


def _fitted(function: Callable[[np.ndarray], np.ndarray], low: float, high: float) -> np.ndarray | None:
    """Coefficients of the shortest polynomial that is right within [low, high], from the constant on; None without.

    A function of several values gets a column each.
    """
    x = np.linspace(low, high, 1001)
    exact = function(x)
    for terms in range(2, MOST_TERMS):
        nodes = np.polynomial.chebyshev.chebpts1(terms)
        values = function((low + high) / 2 + (high - low) / 2 * nodes)
        series = np.linalg.solve(np.polynomial.chebyshev.chebvander(nodes, terms - 1), values)
        to_powers = [np.polynomial.Chebyshev.basis(k, [low, high]) for k in range(terms)]
        matrix = np.zeros((terms, terms))
        for k, basis in enumerate(to_powers):
            found = basis.convert(kind=np.polynomial.Polynomial, domain=[-1, 1], window=[-1, 1]).coef
            matrix[: found.size, k] = found
        coefficients = matrix @ series
        off = np.vander(x, terms, increasing=True) @ coefficients - exact
        if np.abs(off).max() <= ACCURACY * np.abs(exact).max():
            return coefficients
    return None

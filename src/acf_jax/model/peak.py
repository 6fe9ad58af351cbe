"""The peak contact force: Eqs. (9) and (11) of the paper, solved in full.

In tau = omega t, with zeta = d/(2 m omega), kappa = k_C/K, epsilon = k_F/K and p = F_P/(m omega v),
dF_C/dt = 0 reads

    e^{-zeta tau}(a S(tau) - kappa C(tau)) = epsilon,   a = p - kappa zeta,
    C = cos(eta tau), S = sin(eta tau)/eta, eta^2 = 1 - zeta^2.

Its root for epsilon = 0, tau_0, is closed-form. Counted from there, sigma = tau - tau_0, the equation has
one parameter besides zeta: s(sigma) = e^{-zeta sigma} sin(eta sigma)/eta = r. docs/theory.md derives it.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Array, Bool, Float, PyTree

from acf_jax.model.blocks import in_blocks
from acf_jax.model.carlson import carlson_rc
from acf_jax.model.halley import Halley, halley_step
from acf_jax.model.response import contact_force, contact_force_curvature, contact_force_rate
from acf_jax.model.rig import Impact, Rig
from acf_jax.model.stumpff import stumpff_series

Scalar = Float[Array, ""]


class Peak(NamedTuple):
    """The first maximum of the contact force, Eq. (11).

    Without a peak (`has_peak` False: the contact velocity is never compensated) the other two are
    finite stand-ins: force and time at the inflection, where the force comes closest to having a
    maximum, but not later than 50 (1 + zeta)/omega, when what the impact started has decayed.
    """

    f_max: Float[Array, "*batch"]  # N
    t_max: Float[Array, "*batch"]  # s, since contact
    has_peak: Bool[Array, "*batch"]


class Crossing(NamedTuple):
    """The equation s(sigma) = r of one sample, whose root lies in [0, sigma_m] if r <= r_m."""

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


def _residual(sigma: Scalar, crossing: PyTree) -> tuple[Scalar, tuple[Scalar, Scalar]]:
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


def _find_crossing(crossing: Crossing) -> Scalar:
    """sigma to half the digits, by optimistix: F_max is stationary there, and t_max is polished after."""
    half_the_digits = float(jnp.finfo(crossing.zeta.dtype).eps) ** 0.5
    return optx.root_find(
        _residual,  # type: ignore[arg-type]  # optimistix types the auxiliary output as Never
        Halley(rtol=half_the_digits, atol=0.0),
        _guess(crossing),
        args=crossing,
        options={"lower": jnp.zeros_like(crossing.sigma_m), "upper": crossing.sigma_m},
        has_aux=True,
        max_steps=64,
        throw=False,
    ).value


def _solve(rig: Rig, impact: Impact) -> Peak:
    """Force and time of the peak: tau_0, then the root sigma, then Eq. (11) as a sum of positive terms."""
    zeta, kappa, epsilon = rig.zeta, rig.k_c / rig.k, rig.k_f / rig.k
    # F_P and m omega v enter by their shares c and b, so that neither v = 0 nor F_P = 0 divides by zero.
    momentum = impact.v_e * jnp.sqrt(rig.m * rig.k)
    scale = impact.f_p + momentum
    is_loaded = scale > 0
    b = jnp.where(is_loaded, momentum / jnp.where(is_loaded, scale, 1.0), 1.0)
    c = 1 - b

    tiny = jnp.finfo(zeta.dtype).tiny
    eta_squared = (1 - zeta) * (1 + zeta)
    a = c - kappa * zeta * b
    q = a * a + kappa * kappa * b * b * eta_squared
    # Overdamped, the force's slope has a minimum only if the mass starts fast enough.
    is_turning = (eta_squared > 0) | ((a > 0) & (q > 0))
    root_q = jnp.where(is_turning, jnp.sqrt(jnp.maximum(q, tiny)), 1.0)
    angle = kappa * b * carlson_rc(jnp.abs(a), root_q)
    half_period = jnp.pi / jnp.sqrt(jnp.maximum(eta_squared, tiny))
    tau_0 = jnp.where(a < 0, half_period - angle, angle)
    w = jnp.where(is_turning, root_q * jnp.exp(-zeta * tau_0), 0.0)

    sigma_m = carlson_rc(zeta, jnp.ones_like(zeta))
    r_m = jnp.exp(-zeta * sigma_m)
    has_peak = epsilon * b < w * r_m
    ratio = jnp.where(has_peak, epsilon * b / jnp.where(has_peak, w * r_m, 1.0), 1.0)
    crossing = Crossing(zeta, eta_squared, sigma_m, r_m, ratio)
    sigma = _find_crossing(crossing)

    settled = jnp.where(is_turning & has_peak, jnp.inf, 50 * (1 + zeta))
    tau = jnp.where(is_turning, jnp.minimum(tau_0 + sigma, settled), settled)
    # F_max is stationary in sigma and needs no more digits; its evaluation pays t_max one step more.
    residual, (slope, curvature) = _residual(sigma, crossing)
    swing = slope + 2 * zeta * (residual + ratio * r_m)
    f_max = scale * (c * epsilon + kappa * (b * (epsilon * tau + 2 * zeta * kappa) + w * swing))
    polished = halley_step(sigma, (residual, slope, curvature), jnp.zeros_like(sigma), sigma_m)
    return Peak(f_max, (tau + (polished - sigma)) / rig.omega, has_peak)


Gradient = tuple[Rig, Impact]
Map = Callable[[Callable[..., Any]], Callable[..., Any]]


def _sensitivity(rig: Rig, impact: Impact) -> tuple[Peak, Gradient, Gradient]:
    """The peak and the gradients of F_max, by the envelope theorem, and of t_max, by the implicit one.

    t_max comes from `find_peak`, so that differentiating once more moves t as it must. A sample without
    a peak keeps its stand-in time.
    """
    peak = find_peak(rig, impact)
    force_gradient = jax.grad(contact_force, argnums=(0, 1))(rig, impact, peak.t_max)
    rate_gradient = jax.grad(contact_force_rate, argnums=(0, 1))(rig, impact, peak.t_max)
    curvature = contact_force_curvature(rig, impact, peak.t_max)
    moves = peak.has_peak & (curvature < 0)
    per_rate = jnp.where(moves, -1 / jnp.where(moves, curvature, 1.0), 0.0)
    return peak, force_gradient, jax.tree.map(lambda g: per_rate * g, rate_gradient)


def _inner(gradient: Gradient, tangents: Gradient) -> Array:
    return jax.tree.reduce(jnp.add, jax.tree.map(jnp.multiply, gradient, tangents))


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def _peak(mapped: Map, rig: Rig, impact: Impact) -> Peak:
    """`_solve`, for one sample or for many: `mapped` says how."""
    peak: Peak = mapped(_solve)(rig, impact)
    return peak


@_peak.defjvp
def _peak_jvp(mapped: Map, primals: Gradient, tangents: Gradient) -> tuple[Peak, Peak]:
    peak, force_gradient, time_gradient = mapped(_sensitivity)(*primals)
    no_tangent: Any = np.zeros(peak.has_peak.shape, jax.dtypes.float0)
    return peak, Peak(_inner(force_gradient, tangents), _inner(time_gradient, tangents), no_tangent)


def _one_sample(fn: Callable[..., Any]) -> Callable[..., Any]:
    return fn


def find_peak(rig: Rig, impact: Impact) -> Peak:
    """Peak force of one impact: the first root of Eq. (9), put into Eq. (8).

    F_C,max = F_C(t_max),  dF_C/dt(t_max) = 0   (Eqs. 9 and 11)

    **Arguments:** `rig`, `impact`, one sample of scalars.

    **Returns:** `Peak` of scalars. Differentiable to second order in all six parameters, by `jax.grad`,
    `jax.jacfwd` and `jax.hessian`; maps with `jax.vmap`.
    """
    return _peak(_one_sample, rig, impact)


@jax.jit
def find_peaks(rig: Rig, impact: Impact) -> Peak:
    """Peak forces of a batch: `find_peak` in blocks that stay in the cache, several times faster.

    **Arguments:** `rig`, `impact` with fields of shape (N,).

    **Returns:** `Peak` of arrays of shape (N,). Differentiable as `find_peak` is.
    """
    return _peak(in_blocks, rig, impact)

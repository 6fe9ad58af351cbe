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
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Array, Bool, Float

from acf_jax.model.carlson import carlson_rc
from acf_jax.model.halley import Halley, halley_step
from acf_jax.model.response import contact_force, contact_force_curvature, contact_force_rate
from acf_jax.model.rig import Impact, Rig
from acf_jax.model.stumpff import stumpff_series

Scalar = Float[Array, ""]

# Samples a block: its intermediate arrays fit a core's second-level cache.
BLOCK = 8192
# Two steps give t_max to rounding; F_max, stationary in t, has it after one.
_HALLEY_STEPS = 2


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


RootFinder = Callable[[Crossing], Scalar]


def _swing(zeta: Scalar, eta_squared: Scalar, sigma: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """e^{-zeta sigma}, C(sigma), S(sigma) within the bracket: series at sigma/4, its angle doubled twice."""
    z = eta_squared * sigma * sigma / 16
    sine, cosine = stumpff_series(1, z, 9), 1 - z * stumpff_series(2, z, 9)
    for _ in range(2):
        sine, cosine, z = sine * cosine, 1 - 2 * z * sine * sine, 4 * z
    return jnp.exp(-zeta * sigma), cosine, sigma * sine


def _residual(sigma: Scalar, crossing: Crossing) -> tuple[Scalar, tuple[Scalar, Scalar]]:
    """s(sigma) - r with its first two derivatives; the second follows from s'' + 2 zeta s' + s = 0."""
    decay, cosine, sine = _swing(crossing.zeta, crossing.eta_squared, sigma)
    s, slope = decay * sine, decay * (cosine - crossing.zeta * sine)
    return s - crossing.ratio * crossing.r_m, (slope, -2 * crossing.zeta * slope - s)


def _guess(crossing: Crossing) -> Scalar:
    """sigma by a sextic in u = sqrt(1 - r/r_m): exact to third order at the fold, to second at r = 0."""
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
    return jnp.clip(crossing.sigma_m - below, 0.0, crossing.sigma_m)


def halley_steps(crossing: Crossing) -> Scalar:
    """The root by a fixed number of Halley steps: straight-line code, fastest in a batch."""
    sigma = _guess(crossing)
    for _ in range(_HALLEY_STEPS):
        s, (slope, curvature) = _residual(sigma, crossing)
        sigma = halley_step(sigma, (s, slope, curvature), jnp.zeros_like(sigma), crossing.sigma_m)
    return sigma


def halley_to_tolerance(crossing: Crossing) -> Scalar:
    """The root by optimistix, as many Halley steps as rounding allows."""
    rounding = float(jnp.finfo(crossing.zeta.dtype).eps)
    return optx.root_find(
        _residual,
        Halley(rtol=rounding, atol=rounding),
        _guess(crossing),
        args=crossing,
        options={"lower": jnp.zeros_like(crossing.sigma_m), "upper": crossing.sigma_m},
        has_aux=True,
        max_steps=16,
        throw=False,
    ).value


def _solve(find_root: RootFinder, rig: Rig, impact: Impact) -> Peak:
    """Force and time of the peak: tau_0, then the root sigma, then Eq. (11) as a sum of positive terms."""
    zeta, kappa, epsilon = rig.zeta, rig.k_c / rig.k, rig.k_f / rig.k
    # F_P and m omega v enter by their shares b : c, so that neither v = 0 nor F_P = 0 divides by zero.
    momentum = impact.v_e * jnp.sqrt(rig.m * rig.k)
    scale = impact.f_p + momentum
    b = jnp.where(scale > 0, momentum / jnp.where(scale > 0, scale, 1.0), 1.0)
    c = jnp.where(scale > 0, impact.f_p / jnp.where(scale > 0, scale, 1.0), 0.0)

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
    sigma = find_root(Crossing(zeta, eta_squared, sigma_m, r_m, ratio))

    settled = 50 * (1 + zeta)
    inflection = jnp.where(is_turning, jnp.minimum(tau_0 + sigma, settled), settled)
    tau = jnp.where(has_peak, tau_0 + sigma, inflection)
    decay, cosine, sine = _swing(zeta, eta_squared, sigma)
    moving = epsilon * tau + 2 * zeta * kappa
    f_max = scale * (c * epsilon + kappa * (b * moving + w * decay * (cosine + zeta * sine)))
    return Peak(f_max, tau / rig.omega, has_peak)


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def _peak(find_root: RootFinder, rig: Rig, impact: Impact) -> Peak:
    return _solve(find_root, rig, impact)


@_peak.defjvp
def _peak_jvp(
    find_root: RootFinder, primals: tuple[Rig, Impact], tangents: tuple[Rig, Impact]
) -> tuple[Peak, Peak]:
    """dF_max by the envelope theorem, dt_max by the implicit function theorem.

    t_max comes from `_peak` itself, so that differentiating this rule again moves t as it must. A sample
    without a peak keeps its stand-in time.
    """
    peak = _peak(find_root, *primals)
    force_gradient = jax.grad(lambda p: contact_force(*p, peak.t_max))(primals)
    rate_gradient = jax.grad(lambda p: contact_force_rate(*p, peak.t_max))(primals)
    curvature = contact_force_curvature(*primals, peak.t_max)
    moves = peak.has_peak & (curvature < 0)
    per_rate = jnp.where(moves, -1 / jnp.where(moves, curvature, 1.0), 0.0)
    return peak, Peak(
        _inner(force_gradient, tangents),
        per_rate * _inner(rate_gradient, tangents),
        np.zeros(peak.has_peak.shape, jax.dtypes.float0),
    )


def _inner(gradient: tuple[Rig, Impact], tangents: tuple[Rig, Impact]) -> Scalar:
    return jax.tree.reduce(jnp.add, jax.tree.map(jnp.multiply, gradient, tangents))


def find_peak(rig: Rig, impact: Impact) -> Peak:
    """Peak force of one impact: the first root of Eq. (9), by optimistix, put into Eq. (8).

    F_C,max = F_C(t_max),  dF_C/dt(t_max) = 0   (Eqs. 9 and 11)

    **Arguments:** `rig`, `impact`, one sample of scalars.

    **Returns:** `Peak` of scalars. Differentiable to second order in all six parameters, by `jax.grad`,
    `jax.jacfwd` and `jax.hessian`; maps with `jax.vmap`.
    """
    return _peak(halley_to_tolerance, rig, impact)


@jax.jit
def find_peaks(rig: Rig, impact: Impact) -> Peak:
    """Peak forces of a batch: the mathematics of `find_peak`, in blocks that stay in the cache.

    **Arguments:** `rig`, `impact` with fields of shape (N,).

    **Returns:** `Peak` of arrays of shape (N,). Differentiable as `find_peak` is.
    """
    return jax.lax.map(lambda sample: _peak(halley_steps, *sample), (rig, impact), batch_size=BLOCK)

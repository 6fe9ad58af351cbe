"""The peak contact force: Eqs. (9) and (11) of the paper, solved in full.

In tau = omega t, with zeta = d/(2 m omega), kappa = k_C/K, epsilon = k_F/K and p = F_P/(m omega v),
dF_C/dt = 0 reads

    e^{-zeta tau}(a S(tau) - kappa C(tau)) = epsilon,   a = p - kappa zeta,
    C = cos(eta tau), S = sin(eta tau)/eta, eta^2 = 1 - zeta^2.

Its root for epsilon = 0, tau_0, is closed-form. Counted from there, sigma = tau - tau_0, the equation has
one parameter besides zeta: s(sigma) = e^{-zeta sigma} sin(eta sigma)/eta = r. docs/theory.md derives it.
"""

from collections.abc import Callable
from functools import cache, partial
from math import prod
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from acf_jax.kept import VECTORS, knows
from acf_jax.model.blocks import BLOCK, in_blocks
from acf_jax.model.carlson import carlson_rc
from acf_jax.model.crossing import Crossing, find_crossings, polish, residual
from acf_jax.model.response import contact_force, contact_force_curvature, contact_force_rate
from acf_jax.model.rig import Impact, Rig, broadcast, common_shape

Scalar = Float[Array, ""]
RootFinder = Callable[[Crossing], Scalar]
Gradient = tuple[Rig, Impact]


class Peak(NamedTuple):
    """The first maximum of the contact force, Eq. (11).

    Without a peak (`has_peak` False: the contact velocity is never compensated) the other two are
    finite stand-ins: force and time at the inflection, where the force comes closest to having a
    maximum, but not later than 50 (1 + zeta)/omega, when what the impact started has decayed.
    """

    f_max: Float[Array, "*batch"]  # N
    t_max: Float[Array, "*batch"]  # s, since contact
    has_peak: Bool[Array, "*batch"]

    def __repr__(self) -> str:
        if any(isinstance(x, jax.core.Tracer) or not hasattr(x, "__array__") for x in self):
            return f"Peak{tuple(self)}"  # traced, or what a transformation has put in place of numbers
        f_max, t_max, has_peak = map(np.asarray, self)
        if not has_peak.size:
            return "Peak(no impact)"
        without = has_peak.size - int(has_peak.sum())
        if without == has_peak.size:
            return "Peak(none, the force keeps rising)"
        force, time = f_max[has_peak], 1e3 * t_max[has_peak]
        if not has_peak.shape:
            return f"Peak({force[0]:.2f} N after {time[0]:.3f} ms)"
        spans = f"{force.min():.2f} to {force.max():.2f} N after {time.min():.3f} to {time.max():.3f} ms"
        return f"Peak({spans}, {has_peak.size} impacts{f', {without} of them without a peak' if without else ''})"


class Reduced(NamedTuple):
    """One sample as the equation of its stationary points: docs/theory.md derives it."""

    scale: Scalar  # N, F_P + m omega v
    b: Scalar  # m omega v over `scale`
    epsilon: Scalar  # k_F/K
    kappa: Scalar  # k_C/K
    tau_0: Scalar  # omega t of the peak for k_F = 0, a lower bound otherwise
    w: Scalar  # what swings at tau_0, over `scale`; 0 where the force has no turning point
    crossing: Crossing
    is_turning: Bool[
        Array, ""
    ]  # overdamped, the force's slope has a minimum only if the mass starts fast enough
    has_peak: Bool[Array, ""]


def reduce(rig: Rig, impact: Impact) -> Reduced:
    """The crossing s(sigma) = r of one sample, sigma = omega t - tau_0."""
    zeta, kappa, epsilon = rig.zeta, rig.k_c / rig.k, rig.k_f / rig.k
    # F_P and m omega v enter by their shares c and b, so that neither v = 0 nor F_P = 0 divides by zero.
    momentum = impact.v_e * jnp.sqrt(rig.m * rig.k)
    scale = impact.f_p + momentum
    is_loaded = scale > 0
    b = jnp.where(is_loaded, momentum / jnp.where(is_loaded, scale, 1.0), 1.0)

    tiny = jnp.finfo(zeta.dtype).tiny
    eta_squared = (1 - zeta) * (1 + zeta)
    a = (1 - b) - kappa * zeta * b
    q = a * a + kappa * kappa * b * b * eta_squared
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
    return Reduced(scale, b, epsilon, kappa, tau_0, w, crossing, is_turning, has_peak)


def _solve(find_root: RootFinder, rig: Rig, impact: Impact) -> Peak:
    """Force and time of the peak: tau_0, then the root sigma, then Eq. (11) as a sum of positive terms."""
    scale, b, epsilon, kappa, tau_0, w, crossing, is_turning, has_peak = reduce(rig, impact)
    zeta = crossing.zeta
    sigma = find_root(crossing)

    settled = jnp.where(is_turning & has_peak, jnp.inf, 50 * (1 + zeta))
    tau = jnp.where(is_turning, jnp.minimum(tau_0 + sigma, settled), settled)
    # F_max is stationary in sigma and needs no more digits; its evaluation pays t_max one step more.
    difference, (slope, _) = at_sigma = residual(sigma, crossing)
    swing = slope + 2 * zeta * (difference + crossing.ratio * crossing.r_m)
    f_max = scale * ((1 - b) * epsilon + kappa * (b * (epsilon * tau + 2 * zeta * kappa) + w * swing))
    return Peak(f_max, (tau + (polish(sigma, at_sigma, crossing) - sigma)) / rig.omega, has_peak)


@jax.jit  # traced once, not at each of the places and orders that ask for it
def _solve_one(rig: Rig, impact: Impact) -> Peak:
    from acf_jax.model.halley import find_crossing  # slow to import, and a batch does without

    return _solve(find_crossing, rig, impact)


@jax.jit  # for the same reason
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
def _peak(batched: bool, rig: Rig, impact: Impact) -> Peak:
    if not batched:
        return _solve_one(rig, impact)
    peak: Peak = in_blocks(partial(_solve, find_crossings))(rig, impact)
    return peak


@_peak.defjvp
def _peak_jvp(batched: bool, primals: Gradient, tangents: Gradient) -> tuple[Peak, Peak]:
    sensitivity = in_blocks(_sensitivity) if batched else _sensitivity
    peak, force_gradient, time_gradient = sensitivity(*primals)
    no_tangent: Any = np.zeros(peak.has_peak.shape, jax.dtypes.float0)
    return peak, Peak(_inner(force_gradient, tangents), _inner(time_gradient, tangents), no_tangent)


def find_peak(rig: Rig, impact: Impact) -> Peak:
    """Peak force of one impact: the first root of Eq. (9), put into Eq. (8).

    F_C,max = F_C(t_max),  dF_C/dt(t_max) = 0   (Eqs. 9 and 11)

    **Arguments:** `rig`, `impact`, one sample of scalars.

    **Returns:** `Peak` of scalars. Differentiable to second order in all six parameters, by `jax.grad`,
    `jax.jacfwd` and `jax.hessian`; maps with `jax.vmap`.

    **Raises:** `ValueError` for arrays.
    """
    rig, impact = broadcast(rig, impact)
    if shape := rig.m.shape:
        raise ValueError(f"find_peak takes scalars, but the shape of the fields is {shape}; use find_peaks")
    return _peak(False, rig, impact)


def _find_peaks(rig: Rig, impact: Impact) -> Peak:
    rig, impact = broadcast(rig, impact)
    if not (shape := rig.m.shape):
        raise ValueError(
            f"find_peaks takes an array, but the shape of all fields is {shape}; use find_peak instead"
        )
    found: Peak = jax.tree.map(
        lambda x: x.reshape(shape), _peak(True, *jax.tree.map(jnp.ravel, (rig, impact)))
    )
    return found


_as_it_comes = jax.jit(_find_peaks)


@cache
def _in_wide_vectors() -> Callable[[Rig, Impact], Peak]:
    """`_find_peaks` with `VECTORS`, if this version of the compiler knows what it asks for."""
    return jax.jit(_find_peaks, compiler_options=VECTORS) if knows(VECTORS) else _as_it_comes


def find_peaks(rig: Rig, impact: Impact) -> Peak:
    """Peak forces of a batch: `find_peak` in blocks that stay in the cache, several times faster.

    **Arguments:** `rig`, `impact` with fields that are numbers or arrays, which broadcast to one shape, such as (N,).

    **Returns:** `Peak` of arrays of that shape. Differentiable as `find_peak` is.

    **Raises:** `ValueError` for numbers alone, and for shapes that do not fit each other.
    """
    # Only the outermost program has a say in how it is compiled; and few samples take no time, their options some.
    is_few = prod(common_shape(rig, impact)) <= BLOCK
    if is_few or any(isinstance(x, jax.core.Tracer) for x in jax.tree.leaves((rig, impact))):
        return _as_it_comes(rig, impact)
    with jax.ensure_compile_time_eval():  # also where another program, being traced, asks for constants
        return _in_wide_vectors()(rig, impact)

"""The response of the rig to an impact: Eqs. (5) to (9) of the paper, at every damping."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from acf_jax.model.rig import Impact, Rig
from acf_jax.model.stumpff import damped_stumpff

Time = Float[Array, ""]
Scalar = Float[Array, ""]


def _transient(rig: Rig, impact: Impact, t: Time) -> Scalar:
    """e^{-delta t}(a cos nu t + b sin nu t), what decays of Eq. (5); a and b from x(0) = x'(0) = 0."""
    drift = rig.k_c * impact.v_e / rig.k
    a = rig.d * drift / rig.k - impact.f_p / rig.k
    b_nu = rig.delta * a - drift
    alpha = rig.delta * t
    z = (rig.omega - rig.delta) * (rig.omega + rig.delta) * t * t
    return a * damped_stumpff(0, alpha, z) + b_nu * t * damped_stumpff(1, alpha, z)


def position(rig: Rig, impact: Impact, t: Time) -> Scalar:
    """Position of the moving mass after contact, Eq. (5).

    x(t) = e^{-delta t}(a cos nu t + b sin nu t) + F_P/K + k_C v t/K - d k_C v/K^2, K = k_F + k_C

    **Arguments:** `rig`, `impact` one sample; `t` time since contact, s, scalar, >= 0.

    **Returns:** x, m, scalar. Use `jax.vmap` for many times or samples.
    """
    drift = rig.k_c * impact.v_e / rig.k
    return _transient(rig, impact, t) + impact.f_p / rig.k + drift * (t - rig.d / rig.k)


def velocity(rig: Rig, impact: Impact, t: Time) -> Scalar:
    """Velocity of the moving mass after contact, the derivative of Eq. (5).

    **Arguments:** `rig`, `impact` one sample; `t` time since contact, s, scalar, >= 0.

    **Returns:** x', m/s, scalar.
    """
    drift = rig.k_c * impact.v_e / rig.k
    alpha = rig.delta * t
    z = (rig.omega - rig.delta) * (rig.omega + rig.delta) * t * t
    start = impact.f_p / rig.m - rig.delta * drift
    return drift - drift * damped_stumpff(0, alpha, z) + start * t * damped_stumpff(1, alpha, z)


def contact_force(rig: Rig, impact: Impact, t: Time) -> Scalar:
    """Contact force, Eq. (8).

    F_C(t) = k_C (v t - x(t)) + F_P, written without the difference of v t and x that would cancel

    **Arguments:** `rig`, `impact` one sample; `t` time since contact, s, scalar, >= 0.

    **Returns:** F_C, N, scalar. The model holds for a short time only: with k_F > 0 the force rises again.
    """
    kappa, epsilon = rig.k_c / rig.k, rig.k_f / rig.k
    carried = epsilon * (rig.k_c * impact.v_e * t + impact.f_p) + rig.d * kappa * kappa * impact.v_e
    return carried - rig.k_c * _transient(rig, impact, t)


def contact_force_rate(rig: Rig, impact: Impact, t: Time) -> Scalar:
    """dF_C/dt, N/s, whose first zero is t_max: Eq. (9).

    dF_C/dt = k_C (v - x'(t)) = k_C (v k_F/K + e^{-delta t}(A cos nu t + B sin nu t))

    The factor e^{-delta t} does not divide out: see `printed_eq10` for Eq. (10) as the paper prints it.

    **Arguments:** `rig`, `impact` one sample; `t` time since contact, s, scalar, >= 0.

    **Returns:** dF_C/dt, N/s, scalar.
    """
    alpha = rig.delta * t
    z = (rig.omega - rig.delta) * (rig.omega + rig.delta) * t * t
    drift = rig.k_c * impact.v_e / rig.k
    start = impact.f_p / rig.m - rig.delta * drift
    settled = impact.v_e * rig.k_f / rig.k
    moving = drift * damped_stumpff(0, alpha, z) - start * t * damped_stumpff(1, alpha, z)
    return rig.k_c * (settled + moving)


def contact_force_curvature(rig: Rig, impact: Impact, t: Time) -> Scalar:
    """d^2 F_C/dt^2, N/s^2: negative at a peak, zero where a peak is about to vanish (the fold)."""
    return jax.jvp(lambda s: contact_force_rate(rig, impact, s), (t,), (jnp.ones_like(t),))[1]

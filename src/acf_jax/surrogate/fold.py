"""How far one impact is from the fold, where its peak disappears."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from acf_jax.model import Impact, Rig
from acf_jax.model.carlson import carlson_rc

Scalar = Float[Array, ""]


class Fold(NamedTuple):
    """The peak equation of one impact, reduced to zeta and u (docs/theory.md)."""

    u: Scalar  # sqrt(1 - r/r_m): 0 at the fold, 1 for k_F = 0
    tau_0: Scalar  # omega t of the peak for k_F = 0, a lower bound otherwise
    sigma_m: Scalar  # the peak lies in tau_0 + [0, sigma_m]
    has_peak: Bool[Array, ""]


def distance_to_fold(rig: Rig, impact: Impact) -> Fold:
    """The distance u from the fold and the bracket of the peak's time.

    s(sigma) = e^{-zeta sigma} sin(eta sigma)/eta = r,  r_m = max s = s(sigma_m),  u = sqrt(1 - r/r_m)

    **Arguments:** `rig`, `impact`, one sample of scalars.

    **Returns:** `Fold`; without a peak u = 0, with finite gradients.
    """
    zeta, kappa, epsilon = rig.zeta, rig.k_c / rig.k, rig.k_f / rig.k
    # Shares of F_P and m omega v, so that neither is a divisor where it is 0; both 0 stand for v -> 0.
    momentum = impact.v_e * jnp.sqrt(rig.m * rig.k)
    scale = impact.f_p + momentum
    moving = jnp.where(scale > 0, momentum / jnp.where(scale > 0, scale, 1.0), 1.0)
    pressed = jnp.where(scale > 0, impact.f_p / jnp.where(scale > 0, scale, 1.0), 0.0)
    b = kappa * moving
    a = pressed - zeta * b
    eta_squared = (1 - zeta) * (1 + zeta)
    q = a * a + b * b * eta_squared

    is_turning = (eta_squared > 0) | ((a > 0) & (q > 0))
    tiny = jnp.finfo(zeta.dtype).tiny
    root_q = jnp.where(is_turning, jnp.sqrt(jnp.maximum(q, tiny)), 1.0)
    angle = b * carlson_rc(jnp.abs(a), root_q)
    half_period = jnp.pi / jnp.sqrt(jnp.where(eta_squared > 0, eta_squared, 1.0))
    tau_0 = jnp.where((a < 0) & (eta_squared > 0), half_period - angle, angle)

    sigma_m = carlson_rc(zeta, jnp.ones_like(zeta))
    largest = root_q * jnp.exp(-zeta * (tau_0 + sigma_m))
    has_peak = is_turning & (epsilon * moving < largest)
    # its square, which the gradient divides by, must not vanish
    divisor = jnp.maximum(jnp.where(has_peak, largest, 1.0), tiny**0.5)
    ratio = jnp.where(has_peak, epsilon * moving / divisor, 0.0)
    u = jnp.where(has_peak, jnp.sqrt(1 - ratio), 0.0)
    return Fold(u, tau_0, sigma_m, has_peak)

"""Eq. (10) exactly as the paper prints it: an approximation, kept for comparison only."""

import jax.numpy as jnp

from acf_jax.model.peak import Peak
from acf_jax.model.response import contact_force
from acf_jax.model.rig import Impact, Rig


def find_peak_by_printed_eq10(rig: Rig, impact: Impact) -> Peak:
    """Peak force with t_max from Eq. (10) as printed, which drops the factor e^{-delta t} of dF_C/dt = 0.

    A cos(nu t) + B sin(nu t) + C = 0,  C = v k_F/K

    Exact for k_F = 0 or d = 0 only; elsewhere t_max comes too early, and a peak may be found where there
    is none. Use `find_peak` for the full equation.

    **Arguments:** `rig`, `impact`, one sample. Eq. (10) is for underdamped rigs: others get `has_peak` False.

    **Returns:** `Peak`; without a root, force and time where the left-hand side is smallest.
    """
    is_underdamped = rig.delta < rig.omega
    nu_squared = jnp.where(is_underdamped, (rig.omega - rig.delta) * (rig.omega + rig.delta), 1.0)
    nu = jnp.sqrt(nu_squared)
    a = rig.k_c * impact.v_e / rig.k
    b = (rig.delta * a - impact.f_p / rig.m) / nu
    c = impact.v_e * rig.k_f / rig.k
    amplitude = jnp.hypot(a, b)
    share = jnp.minimum(c / jnp.where(amplitude > 0, amplitude, 1.0), 1.0)
    t_max = (jnp.atan2(a, -b) + jnp.asin(share)) / nu
    return Peak(contact_force(rig, impact, t_max), t_max, is_underdamped & (c < amplitude))

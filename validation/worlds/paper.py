"""The contact force without causes: the solution of the paper's equations, for many impacts at once."""

import numpy as np

from validation.worlds.interface import Array, Rig


def contact_force(rig: Rig, v_e: Array, f_p: Array, time: Array) -> Array:
    """The force of m x'' + d x' + k_F x = F_C = k_C (v t - x) + F_P at any time, as if contact were never lost.

    x = a t + b - e^{-delta t} (b cos(nu t) + (a + delta b)/nu sin(nu t)), with nu imaginary beyond critical damping.

    **Arguments:** `v_e`, `f_p`: m/s and N, shape (n, 1). `time`: s, shape (n, samples).

    **Returns:** N, shape (n, samples).
    """
    stiffness = rig.k_f + rig.k_c
    delta = rig.d / (2.0 * rig.m)
    nu = np.sqrt(complex(stiffness / rig.m - delta**2)) + 1e-9  # at critical damping the limit, to rounding
    slope = rig.k_c * v_e / stiffness
    level = (f_p - rig.d * slope) / stiffness
    swing = level * np.cos(nu * time) + (slope + delta * level) / nu * np.sin(nu * time)
    x = slope * time + level - np.exp(-delta * time) * swing.real
    return np.asarray(rig.k_c * (v_e * time - x) + f_p)


def until_lost(force: Array) -> Array:
    """Forces (n, samples) that end with the first sample at which the contact would pull."""
    return np.where(np.logical_or.accumulate(force <= 0.0, axis=1), 0.0, force)

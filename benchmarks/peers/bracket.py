"""Exact brackets of the peak time, and Eq. (9) as a user of SciPy writes it; both in numpy."""

from typing import Any, NamedTuple

import numpy as np

from benchmarks.box import Box, Column


class Bracket(NamedTuple):
    """Where the first root of Eq. (9) lies, in tau = omega t: given to every peer for nothing."""

    chosen: Any  # the samples that have a peak, underdamped ones first
    lower: Column
    upper: Column
    guess: Column  # docs/theory.md: closed form, right to about 1 %


class Equation(NamedTuple):
    """e^{-zeta tau}(A C(tau) + B S(tau)) + epsilon = 0, C = cos(eta tau), S = sin(eta tau)/eta."""

    zeta: Any
    eta: Any  # sqrt|1 - zeta^2|
    a: Any
    b: Any
    epsilon: Any


def guess(zeta: Any, sigma_m: Any, r_m: Any, u: Any) -> Any:
    """The closed-form guess of sigma with u = sqrt(1 - r/r_m); for floats and for arrays of any library."""
    root_2 = 2**0.5
    c_2, c_3 = -2 / 3 * zeta, (1 / 6 + 4 / 9 * zeta * zeta) / root_2
    value = sigma_m - (root_2 + c_2 + c_3)
    slope = 2 * r_m - (root_2 + 2 * c_2 + 3 * c_3)
    curvature = 2 * r_m - 8 * zeta * r_m * r_m - (2 * c_2 + 6 * c_3)
    c_6 = curvature / 2 - 4 * slope + 10 * value
    c_5 = slope - 4 * value - 2 * c_6
    c_4 = value - c_5 - c_6
    return sigma_m - u * (root_2 + u * (c_2 + u * (c_3 + u * (c_4 + u * (c_5 + u * c_6)))))


def equation(box: Box) -> Equation:
    """The coefficients of Eq. (9), dimensionless."""
    k = box.k_f + box.k_c
    omega, kappa = np.sqrt(k / box.m), box.k_c / k
    zeta = box.d / (2 * box.m * omega)
    b = kappa * zeta - box.f_p / (box.m * omega * box.v_e)
    return Equation(zeta, np.sqrt(np.abs((1 - zeta) * (1 + zeta))), kappa, b, box.k_f / k)


def bracket(box: Box) -> Bracket:
    """[tau_0, tau_0 + sigma_m] of those samples that have a peak."""
    zeta, eta, kappa, b, epsilon = equation(box)
    under, q = zeta < 1, b * b + kappa * kappa * (1 - zeta) * (1 + zeta)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        tau_0 = np.where(under, np.arctan2(kappa * eta, -b), np.arctanh(-kappa * eta / b)) / eta
        sigma_m = np.where(under, np.arctan2(eta, zeta), np.arctanh(np.minimum(eta / zeta, 1))) / eta
        r, r_m = epsilon / np.sqrt(q) * np.exp(zeta * tau_0), np.exp(-zeta * sigma_m)
        with_peak = (under | ((b < 0) & (q > 0))) & (r < r_m)
        sigma = guess(zeta, sigma_m, r_m, np.sqrt(1 - r / r_m))
    chosen = np.concatenate([np.flatnonzero(with_peak & under), np.flatnonzero(with_peak & ~under)])
    return Bracket(chosen, tau_0[chosen], (tau_0 + sigma_m)[chosen], (tau_0 + sigma)[chosen])


def force_and_time(box: Box, tau: Column) -> Column:
    """F_C from Eqs. (5) to (8), N, and t, s, at tau = omega t, (2, N), for a box of one damping regime."""
    zeta, eta, kappa, _, _ = equation(box)
    k, omega = box.k_f + box.k_c, np.sqrt((box.k_f + box.k_c) / box.m)
    drift = kappa * box.v_e / omega  # of x in tau, m
    rest = box.f_p / k - 2 * zeta * drift
    cos, sin = (np.cos, np.sin) if zeta[0] < 1 else (np.cosh, np.sinh)
    swing = rest * cos(eta * tau) + (drift + zeta * rest) * sin(eta * tau) / eta
    x = rest + drift * tau - np.exp(-zeta * tau) * swing
    return np.stack([box.k_c * (box.v_e * tau / omega - x) + box.f_p, tau / omega])

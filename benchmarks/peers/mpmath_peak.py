"""The truth: the first root of dF_C/dt in 40 digits, from the paper's Eqs. (3), (8) and (9) alone."""

from typing import Any

import mpmath
import numpy as np

from benchmarks.box import Box, Column


def peaks(box: Box, indices: Any) -> Column:
    """F_C at its first stationary point, N, and the time of that, s, (2, N); by a scan, then a root find.

    With lambda_1, lambda_2 the roots of m lambda^2 + d lambda + K = 0, x(t) is a sum of two complex
    exponentials and the particular solution: no formula shared with `acf_jax.model`.
    """
    return np.array([[float(y) for y in _one(*(float(column[i]) for column in box))] for i in indices]).T


def slope_in_f_p(box: Box, indices: Any) -> Column:
    """dF_max/dF_P, (1, N), by central differences of 1e-9 N in 40 digits: right to 1e-18."""
    step = mpmath.mpf("1e-9")
    slopes = []
    for i in indices:
        *others, f_p = (float(column[i]) for column in box)
        with mpmath.workdps(40):
            above, below = (_one(*others, f_p + shift)[0] for shift in (step, -step))
            slopes.append(float((above - below) / (2 * step)))
    return np.array([slopes])


def _one(m: float, d: float, k_f: float, k_c: float, v_e: float, f_p: Any) -> tuple[Any, Any]:
    with mpmath.workdps(40):
        m, d, k_f, k_c, v_e, f_p = map(mpmath.mpf, (m, d, k_f, k_c, v_e, f_p))
        k = k_f + k_c
        root = mpmath.sqrt(mpmath.mpc(d * d - 4 * m * k))
        lambda_1, lambda_2 = (-d + root) / (2 * m), (-d - root) / (2 * m)
        drift = k_c * v_e / k
        offset = f_p / k - d * drift / k
        c_1 = (lambda_2 * offset - drift) / (lambda_1 - lambda_2)
        c_2 = -offset - c_1

        def x_dot(t: Any) -> Any:
            both = c_1 * lambda_1 * mpmath.exp(lambda_1 * t) + c_2 * lambda_2 * mpmath.exp(lambda_2 * t)
            return mpmath.re(both) + drift

        omega = mpmath.sqrt(k / m)
        step = mpmath.mpf(1) / 50 / omega
        t = step
        while x_dot(t) < v_e:
            t += step
            if t * omega > 30:
                raise ValueError("no peak within 30/omega; give samples that have one")
        t_max = mpmath.findroot(lambda s: x_dot(s) - v_e, (t - step, t), solver="anderson", tol=1e-60)
        both = c_1 * mpmath.exp(lambda_1 * t_max) + c_2 * mpmath.exp(lambda_2 * t_max)
        position = mpmath.re(both) + offset + drift * t_max
        return k_c * (v_e * t_max - position) + f_p, t_max

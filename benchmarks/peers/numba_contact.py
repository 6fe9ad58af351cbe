"""An integrator of its own of flange, contact and body: what `check` says is held against it."""

import math

import numba
import numpy as np

PER_RADIAN = 0.02  # omega h


@numba.njit(cache=True)
def _force(k, f_p, pulls, u, x, y):
    f = k * (u - x - y) + f_p
    return f if f > 0.0 or pulls else 0.0


@numba.njit(cache=True)
def _robot(v, reaction, deceleration, t):
    if t <= reaction or deceleration == 0.0:
        return v * t
    since = min(t - reaction, v / deceleration)
    return v * (reaction + since) - 0.5 * deceleration * since * since


@numba.njit(cache=True)
def _step(c, pulls, t, h, s, rate, out):
    """The classical Runge-Kutta method; s holds x, x', y, y' and becomes `out`."""
    m, d, k_f, k, mobility, v, f_p, reaction, deceleration = c[:9]
    for stage in range(4):
        share = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
        for j in range(4):
            out[j] = s[j] + (share * h * rate[stage - 1, j] if stage > 0 else 0.0)
        f = _force(k, f_p, pulls, _robot(v, reaction, deceleration, t + share * h), out[0], out[2])
        rate[stage, 0] = out[1]
        rate[stage, 1] = (f - d * out[1] - k_f * out[0]) / m
        rate[stage, 2] = out[3]
        rate[stage, 3] = f * mobility
    for j in range(4):
        out[j] = s[j] + h / 6.0 * (rate[0, j] + 2.0 * rate[1, j] + 2.0 * rate[2, j] + rate[3, j])


@numba.njit(cache=True)
def _largest(c, pulls):
    """The largest contact force of one contact until it ends, N; where contact is lost or made a step ends."""
    m, d, k_f, k, mobility, v, f_p, reaction, deceleration, end = c
    shortest = min(end, reaction, v / deceleration) if deceleration > 0.0 else end
    h = min(PER_RADIAN / max(math.sqrt((k_f + k) * (1.0 / m + mobility)), d / m), shortest / 20.0)
    n = math.ceil(end / h)
    h = end / n
    s, out, rate = np.zeros(4), np.zeros(4), np.zeros((4, 4))
    largest = before = f_p
    for i in range(n):
        t = i * h
        _step(c, pulls, t, h, s, rate, out)
        after = _force(k, f_p, True, _robot(v, reaction, deceleration, t + h), out[0], out[2])
        if not pulls and before * after < 0.0:
            low, high = 0.0, h
            for _ in range(40):
                middle = 0.5 * (low + high)
                _step(c, pulls, t, middle, s, rate, out)
                f = _force(k, f_p, True, _robot(v, reaction, deceleration, t + middle), out[0], out[2])
                low, high = (middle, high) if f * before > 0.0 else (low, middle)
            _step(c, pulls, t, high, s, rate, out)
            s[:] = out
            _step(c, pulls, t + high, h - high, s, rate, out)
            after = _force(k, f_p, True, _robot(v, reaction, deceleration, t + h), out[0], out[2])
        s[:] = out
        before = after
        largest = max(largest, after)
    return largest


@numba.njit(parallel=True, cache=True)
def largest_forces(contacts, pulls):
    """(n,) largest forces of contacts, (n, 10): m, d, k_F, k, 1/m_H, v, F_P, reaction, deceleration (0: none), end."""
    out = np.empty(len(contacts))
    for i in numba.prange(len(contacts)):
        out[i] = _largest(contacts[i], pulls)
    return out

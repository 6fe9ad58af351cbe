"""An integrator of its own of robot, flange, contact and body: what `check` says is held against it.

Unlike the library it counts every position from the body's place at first contact, a flange's and a body's alike, and
the actuator joins the flange to the robot, wherever that is.
"""

import math

import numba
import numpy as np

PER_RADIAN = 0.02  # omega h
LEAST_STEPS = 20  # of each of the robot's phases


@numba.njit(cache=True)
def _robot(c, t):
    """Position and velocity: v until it brakes, then down to rest."""
    v, begin, deceleration = c[5], c[7], c[8]
    if t <= begin or deceleration == 0.0:
        return v * t, v
    if deceleration == math.inf:
        return v * begin, 0.0
    since = min(t - begin, v / deceleration)
    return v * (begin + since) - 0.5 * deceleration * since * since, v - deceleration * since


@numba.njit(cache=True)
def _force(c, pulls, flange, body):
    f = c[3] * (flange - body) + c[6]
    return f if f > 0.0 or pulls else 0.0


@numba.njit(cache=True)
def _step(c, pulls, t, h, s, rate, out):
    """The classical Runge-Kutta method; s holds position and velocity of flange and body and becomes `out`."""
    for stage in range(4):
        share = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
        for j in range(4):
            out[j] = s[j] + (share * h * rate[stage - 1, j] if stage > 0 else 0.0)
        # one phase's law to the phase's very ends
        robot, speed = _robot(c, t + (1e-9 + share * (1.0 - 2e-9)) * h)
        f = _force(c, pulls, out[0], out[2])
        rate[stage, 0] = out[1]
        rate[stage, 1] = (c[1] * (speed - out[1]) + c[2] * (robot - out[0]) - f) / c[0]
        rate[stage, 2] = out[3]
        rate[stage, 3] = f * c[4]
    for j in range(4):
        out[j] = s[j] + h / 6.0 * (rate[0, j] + 2.0 * rate[1, j] + 2.0 * rate[2, j] + rate[3, j])


@numba.njit(cache=True)
def _largest(c, pulls, found):
    """Largest contact forces until the robot has stopped, and until the end, N; contact lost or made ends a step."""
    m, d, k_f, k, mobility, v, f_p, begin, deceleration, end = c
    stop = begin + v / deceleration if deceleration > 0.0 else end
    corners = np.array([0.0, min(begin, end), min(stop, end), end])
    longest = PER_RADIAN / max(math.sqrt((k_f + k) * (1.0 / m + mobility)), d / m)
    s, out, rate = np.zeros(4), np.zeros(4), np.zeros((4, 4))
    s[1] = v
    largest = earlier = before = f_p
    for part in range(3):
        if part == 2:
            found[0] = largest
        span = corners[part + 1] - corners[part]
        if span <= 0.0:
            continue
        n = max(math.ceil(span / longest), LEAST_STEPS)
        h = span / n
        holds = pulls and part < 2  # a flange that goes on by itself is not held
        for i in range(n):
            t = corners[part] + i * h
            _step(c, holds, t, h, s, rate, out)
            after = _force(c, True, out[0], out[2])
            if not holds and before * after < 0.0:
                low, high = 0.0, h
                for _ in range(40):
                    middle = 0.5 * (low + high)
                    _step(c, holds, t, middle, s, rate, out)
                    low, high = (
                        (middle, high) if _force(c, True, out[0], out[2]) * before > 0.0 else (low, middle)
                    )
                _step(c, holds, t, high, s, rate, out)
                s[:] = out
                _step(c, holds, t + high, h - high, s, rate, out)
                after = _force(c, True, out[0], out[2])
            s[:] = out
            bend = earlier - 2.0 * before + after
            if i > 0 and before >= earlier and before >= after and bend < 0.0:  # a parabola's top
                largest = max(largest, before - 0.125 * (earlier - after) ** 2 / bend)
            earlier, before = before, after
            largest = max(largest, after)
    found[1] = largest


@numba.njit(parallel=True, cache=True)
def largest_forces(contacts, pulls):
    """Largest forces (n, 2) of contacts (n, 10), N: until the robot has stopped, and until the end.

    A contact is m, d, k_F, k, 1/m_H, v, F_P, the time at which the robot brakes, its deceleration (0: it never does,
    infinite: it stops at once) and the end. With `pulls` a contact that would be lost holds until the robot's stop.
    """
    out = np.empty((len(contacts), 2))
    for i in numba.prange(len(contacts)):
        _largest(contacts[i], pulls, out[i])
    return out

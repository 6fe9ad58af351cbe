"""The exact peak in numba: the algorithm of `acf_jax.model`, compiled for all cores.

Three variants, because numba calls the C library for each `exp`, `sin` or `atan` and does not vectorise a
loop that calls out:

- "C library's functions": branches, `math.sin`, `math.atan2` and so on, as one writes it first;
- "branch-free": JAX's own formulas (Carlson's R_C, Stumpff series), so that only `math.exp` calls out;
- "branch-free, own exp": the same with a hand-written `exp`, so that the loop becomes vector instructions.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import int64, njit, prange, types
from numba.extending import intrinsic

from benchmarks.box import Box
from benchmarks.peers.bracket import guess
from benchmarks.peers.peer import Peer

# Without "nnan" and "ninf": the numerics below rely on neither, and the C library's results stay exact.
FAST = {"contract", "arcp", "nsz", "reassoc"}
_jit = njit(fastmath=FAST, error_model="numpy", inline="always")

_C1 = tuple((-1) ** j / math.factorial(2 * j + 1) for j in range(9))
_C2 = tuple((-1) ** j / math.factorial(2 * j + 2) for j in range(9))
_EXP = tuple(1 / math.factorial(j) for j in range(13))
_TURNS = 5  # as many as acf_jax.model.carlson has


@intrinsic
def _from_bits(typing_context: Any, bits: Any) -> Any:
    """The float64 with these 64 bits."""
    return types.float64(types.int64), lambda _, builder, __, args: builder.bitcast(args[0], ir.DoubleType())


@_jit
def _library_exp(x):
    return math.exp(x)


@_jit
def _vector_exp(x):
    """e^x = 2^k e^y, |y| <= ln(2)/2, by Taylor's series; x <= 0 here."""
    x = max(x, -700.0)
    k = math.floor(x * 1.4426950408889634 + 0.5)
    y = x - k * 0.6931471803691238 - k * 1.9082149292705877e-10
    total = _EXP[12]
    for j in range(11, -1, -1):
        total = _EXP[j] + y * total
    return total * _from_bits((int64(k) + 1023) << 52)


@_jit
def _carlson_rc(g, h):
    for _ in range(_TURNS):
        g = (g + h) * 0.5
        h = math.sqrt(g * h)
    mean = (g * g + 2 * h * h) / 3
    s = (h * h - mean) / mean
    series = 1 + s * s * (3 / 10 + s * (1 / 7 + s * (3 / 8 + s * (9 / 22 + s * (159 / 208 + s * 9 / 8)))))
    return series / math.sqrt(mean)


@_jit
def _library_rc(g, h):
    """R_C(g^2, h^2) by the arc functions of the C library."""
    gap = (h - g) * (h + g)
    if gap > 1e-12 * h * h:
        root = math.sqrt(gap)
        return math.atan(root / g) / root
    if gap < -1e-12 * h * h:
        root = math.sqrt(-gap)
        return math.atanh(root / g) / root
    return 1 / h


_guess = _jit(guess)


@_jit
def _series_swing(zeta, eta_squared, sigma, exp):
    """e^{-zeta sigma}, C(sigma), S(sigma): the series at sigma/4, its angle doubled twice."""
    z = eta_squared * sigma * sigma * 0.0625
    sine, versine = _C1[8], _C2[8]
    for j in range(7, -1, -1):
        sine = _C1[j] + z * sine
        versine = _C2[j] + z * versine
    cosine = 1 - z * versine
    for _ in range(2):
        sine, cosine, z = sine * cosine, 1 - 2 * z * sine * sine, 4 * z
    return exp(-zeta * sigma), cosine, sigma * sine


@_jit
def _library_swing(zeta, eta_squared, sigma, exp):
    decay = exp(-zeta * sigma)
    if eta_squared > 1e-12:
        eta = math.sqrt(eta_squared)
        return decay, math.cos(eta * sigma), math.sin(eta * sigma) / eta
    if eta_squared < -1e-12:
        eta = math.sqrt(-eta_squared)
        grown = exp(eta * sigma)
        return decay, (grown + 1 / grown) / 2, (grown - 1 / grown) / (2 * eta)
    return decay, 1.0, sigma


def _build(
    exp: Callable[..., Any], rc: Callable[..., Any], swing: Callable[..., Any], leaves: bool
) -> Callable[..., Any]:
    """The parallel loop with these functions; with `leaves` it drops samples without a peak early."""

    @_jit
    def residual(zeta, eta_squared, r, sigma):
        decay, cosine, sine = swing(zeta, eta_squared, sigma, exp)
        s, slope = decay * sine, decay * (cosine - zeta * sine)
        return s - r, slope, -2 * zeta * slope - s

    @_jit
    def halley(f, slope, curvature):
        denominator = slope * slope - f * curvature / 2
        return f * slope / (denominator if denominator > 0 else 1.0)

    @njit(parallel=True, fastmath=FAST, error_model="numpy")
    def peaks(m, d, k_f, k_c, v_e, f_p):
        f_max, t_max = np.empty_like(m), np.empty_like(m)
        has_peak = np.empty(m.size, np.bool_)
        for i in prange(m.size):
            k = k_f[i] + k_c[i]
            omega = math.sqrt(k / m[i])
            zeta, kappa, epsilon = d[i] / (2 * m[i] * omega), k_c[i] / k, k_f[i] / k
            scale = m[i] * omega * v_e[i]
            p = f_p[i] / scale
            eta_squared = (1 - zeta) * (1 + zeta)
            a = p - kappa * zeta
            q = a * a + kappa * kappa * eta_squared
            turns = (eta_squared > 0) | ((a > 0) & (q > 0))
            root_q = math.sqrt(q if turns else 1.0)
            angle = kappa * rc(abs(a), root_q)
            half_period = math.pi / math.sqrt(eta_squared if eta_squared > 0 else 1.0)
            tau_0 = half_period - angle if a < 0 else angle
            w = root_q * exp(-zeta * tau_0)
            sigma_m = rc(zeta, 1.0)
            r_m = exp(-zeta * sigma_m)
            has = turns & (epsilon < w * r_m)
            if leaves and not has:
                f_max[i], t_max[i], has_peak[i] = 0.0, 0.0, False
                continue
            ratio = epsilon / (w * r_m) if has else 1.0
            sigma = _guess(zeta, sigma_m, r_m, math.sqrt(1 - ratio))
            r = ratio * r_m
            f, slope, curvature = residual(zeta, eta_squared, r, sigma)
            sigma -= halley(f, slope, curvature)
            # F_max is stationary and needs no second step; its evaluation gives t_max one.
            f, slope, curvature = residual(zeta, eta_squared, r, sigma)
            tau = tau_0 + sigma
            moving = epsilon * tau + 2 * zeta * kappa
            f_max[i] = f_p[i] * epsilon + kappa * scale * (moving + w * (slope + 2 * zeta * (f + r)))
            t_max[i] = (tau - halley(f, slope, curvature)) / omega
            has_peak[i] = has
        return f_max, t_max, has_peak

    return peaks


VARIANTS = {
    "C library's functions": _build(_library_exp, _library_rc, _library_swing, True),
    "branch-free": _build(_library_exp, _carlson_rc, _series_swing, False),
    "branch-free, own exp": _build(_vector_exp, _carlson_rc, _series_swing, False),
}


def peers(box: Box) -> list[Peer]:
    """All variants, on the whole box."""

    def peer(variant: str) -> Peer:
        peaks = VARIANTS[variant]
        everything = np.arange(len(box.m))
        return Peer(f"numba, {variant}", lambda: peaks(*box), lambda result: np.stack(result[:2]), everything)

    return [peer(variant) for variant in VARIANTS]

"""The peak by SciPy: `elementwise.find_root` on arrays in threads, and loops of `brentq`."""

import math
import multiprocessing
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import brentq, elementwise

from benchmarks.box import Box, Column, take
from benchmarks.machine import cores
from benchmarks.peers.bracket import Bracket, equation, force_and_time
from benchmarks.peers.peer import Peer

CHUNK = 20_000  # samples a call of find_root; the fastest of 5e3, 1e4, 2e4, 5e4 and 1e5


def _under(tau: Column, zeta: Column, eta: Column, a: Column, b: Column, epsilon: Column) -> Column:
    angle = eta * tau
    return np.exp(-zeta * tau) * (a * np.cos(angle) + b * np.sin(angle)) + epsilon


def _over(tau: Column, zeta: Column, eta: Column, a: Column, b: Column, epsilon: Column) -> Column:
    angle = eta * tau
    return np.exp(-zeta * tau) * (a * np.cosh(angle) + b * np.sinh(angle)) + epsilon


def elementwise_find_root(box: Box, ends: Bracket, tolerance: float) -> Peer:
    """`elementwise.find_root` (Chandrupatla) in the exact bracket, in chunks of one regime on all cores."""
    pool = ThreadPoolExecutor(cores())
    size, zeta = len(ends.chosen), equation(take(box, ends.chosen)).zeta
    border = int(np.searchsorted(zeta >= 1, True))  # the underdamped come first
    edges = sorted({*range(0, border, CHUNK), *range(border, size, CHUNK), size})
    jobs = [
        (take(box, ends.chosen[start:stop]), ends.lower[start:stop], ends.upper[start:stop])
        for start, stop in pairwise(edges)
    ]
    tolerances = {"xatol": tolerance, "xrtol": 0.0, "fatol": 0.0, "frtol": 0.0}

    def solve(job: tuple[Box, Column, Column]) -> Column:
        chunk, lower, upper = job
        zeta, eta, a, b, epsilon = equation(chunk)
        function = _under if zeta[0] < 1 else _over
        args = (zeta, eta, a, b / eta, epsilon)
        return force_and_time(
            chunk, elementwise.find_root(function, (lower, upper), args=args, tolerances=tolerances).x
        )

    def call() -> Column:
        return np.concatenate(list(pool.map(solve, jobs)), axis=1)

    return Peer("scipy elementwise.find_root", call, lambda result: result, ends.chosen)


def _brentq_loop(job: tuple[tuple[Column, ...], float]) -> Column:
    """F_max and t_max of one sample after the other, in plain floats, (2, N)."""
    columns, tolerance = job
    exp, sqrt = math.exp, math.sqrt
    rtol = 4 * np.finfo(float).eps
    peaks = []
    for m, d, k_f, k_c, v_e, f_p, lower, upper in zip(*(c.tolist() for c in columns), strict=True):
        k = k_f + k_c
        omega, kappa, epsilon = sqrt(k / m), k_c / k, k_f / k
        zeta = d / (2 * m * omega)
        eta = sqrt(abs((1 - zeta) * (1 + zeta)))
        cos, sin = (math.cos, math.sin) if zeta < 1 else (math.cosh, math.sinh)
        b = (kappa * zeta - f_p / (m * omega * v_e)) / eta

        def rate(tau: float) -> float:
            angle = eta * tau  # noqa: B023
            return exp(-zeta * tau) * (kappa * cos(angle) + b * sin(angle)) + epsilon  # noqa: B023

        tau = brentq(rate, lower, upper, xtol=tolerance, rtol=rtol)
        drift = kappa * v_e / omega
        rest = f_p / k - 2 * zeta * drift
        swing = rest * cos(eta * tau) + (drift + zeta * rest) * sin(eta * tau) / eta
        x = rest + drift * tau - exp(-zeta * tau) * swing
        peaks.append((k_c * (v_e * tau / omega - x) + f_p, tau / omega))
    return np.array(peaks).T


def brentq_loop(box: Box, ends: Bracket, tolerance: float) -> Peer:
    """A loop of `brentq` in the exact bracket, in one process."""
    columns = (*take(box, ends.chosen), ends.lower, ends.upper)
    name = "scipy brentq, a loop"
    return Peer(name, lambda: _brentq_loop((columns, tolerance)), lambda result: result, ends.chosen)


def brentq_processes(box: Box, ends: Bracket, tolerance: float) -> Peer:
    """The same loop in one process a core."""
    # "spawn": a forked child of a process that runs JAX's threads may hang.
    pool = ProcessPoolExecutor(cores(), mp_context=multiprocessing.get_context("spawn"))
    columns = (*take(box, ends.chosen), ends.lower, ends.upper)
    jobs: list[Any] = [(tuple(c[i :: cores()] for c in columns), tolerance) for i in range(cores())]

    def call() -> Column:
        peaks = np.empty((2, len(ends.lower)))
        for i, part in enumerate(pool.map(_brentq_loop, jobs)):
            peaks[:, i :: cores()] = part
        return peaks

    return Peer("scipy brentq, a loop in each process", call, lambda result: result, ends.chosen)

"""The wide box: the parameter range over which speed and accuracy are compared."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Column = NDArray[np.float64]


class Box(NamedTuple):
    """Samples of the six parameters, SI units, each of shape (N,)."""

    m: Column  # kg, 0.5..10, log-uniform
    d: Column  # N s/m, from zeta = 0..1.5, uniform
    k_f: Column  # N/m, 0..1e4, uniform
    k_c: Column  # N/m, 1e4..1e6, log-uniform
    v_e: Column  # m/s, 0.01..1, log-uniform
    f_p: Column  # N, 0..500, uniform


def draw_box(size: int, seed: int = 0) -> Box:
    """`size` samples of the wide box."""
    random = np.random.default_rng(seed)

    def log_uniform(low: float, high: float) -> Column:
        return np.exp(random.uniform(np.log(low), np.log(high), size))

    m, k_c, v_e = log_uniform(0.5, 10), log_uniform(1e4, 1e6), log_uniform(0.01, 1)
    k_f, zeta, f_p = random.uniform(0, 1e4, size), random.uniform(0, 1.5, size), random.uniform(0, 500, size)
    return Box(m, 2 * zeta * np.sqrt(m * (k_f + k_c)), k_f, k_c, v_e, f_p)


def take(box: Box, which: Any) -> Box:
    """The samples `which` (indices or a slice) of the box."""
    return Box(*(column[which] for column in box))

"""Numerical truth: the paper's model in 60 digits, derived apart from the code under test.

The mass's velocity V = x' obeys m V'' + d V' + K V = k_C v with V(0) = 0, V'(0) = F_P/m, so it is a sum of
two exponentials with complex rates; the contact force is the integral of k_C (v - V).
"""

from typing import NamedTuple

import mpmath as mp
import numpy as np

mp.mp.dps = 60

# m, d, k_f, k_c, v_e, f_p in SI units
Sample = tuple[float, float, float, float, float, float]


class Truth(NamedTuple):
    f_max: mp.mpf
    t_max: mp.mpf


def _motion(sample: Sample) -> tuple[list[mp.mpc], list[mp.mpc], mp.mpf]:
    m, d, k_f, k_c, v, f_p = map(mp.mpf, sample)
    k = k_f + k_c
    if d * d == 4 * m * k:
        d *= 1 + mp.mpf(10) ** -40
    root = mp.sqrt(mp.mpc(d * d - 4 * m * k))
    rates = [(-d + root) / (2 * m), (-d - root) / (2 * m)]
    settled = k_c * v / k
    first = (f_p / m + rates[1] * settled) / (rates[0] - rates[1])
    return rates, [first, -settled - first], settled


def force(sample: Sample, t: mp.mpf) -> mp.mpf:
    """F_C(t), N."""
    rates, amounts, settled = _motion(sample)
    _, _, _, k_c, v, f_p = map(mp.mpf, sample)
    x = settled * t + sum(a * mp.expm1(q * t) / q for a, q in zip(amounts, rates, strict=True))
    return f_p + k_c * (v * t - mp.re(x))


def force_rate(sample: Sample, t: mp.mpf) -> mp.mpf:
    """dF_C/dt, N/s."""
    rates, amounts, settled = _motion(sample)
    _, _, _, k_c, v, _ = map(mp.mpf, sample)
    return k_c * (v - settled - mp.re(sum(a * mp.exp(q * t) for a, q in zip(amounts, rates, strict=True))))


def inflection(sample: Sample) -> mp.mpf | None:
    """Where the force rises least, the first t > 0 with V' = 0; None if its slope has no minimum."""
    rates, amounts, _ = _motion(sample)
    ratio = -rates[1] * amounts[1] / (rates[0] * amounts[0])
    if mp.im(rates[0]) != 0:
        angle = mp.arg(ratio) % (2 * mp.pi)
        return (angle if angle > mp.mpf(10) ** -9 else angle + 2 * mp.pi) / (2 * mp.im(rates[0]))
    growth = mp.re(ratio)
    is_turning = growth > 1 + mp.mpf(10) ** -30
    return mp.log(growth) / mp.re(rates[0] - rates[1]) if is_turning else None


def peak(sample: Sample) -> Truth | None:
    """The first maximum of the contact force, or None."""
    end = inflection(sample)
    if end is None or force_rate(sample, end) >= 0:
        return None
    rates, amounts, settled = _motion(sample)
    steady = mp.mpf(sample[4]) - settled

    def rate(t: mp.mpf) -> mp.mpf:
        return steady - mp.re(sum(a * mp.exp(q * t) for a, q in zip(amounts, rates, strict=True)))

    def rate_slope(t: mp.mpf) -> mp.mpf:
        return -mp.re(sum(a * q * mp.exp(q * t) for a, q in zip(amounts, rates, strict=True)))

    low, high = mp.mpf(0), end
    for _ in range(50):  # halvings assume nothing about the rate's shape
        middle = (low + high) / 2
        low, high = (middle, high) if rate(middle) > 0 else (low, middle)
    t_max = low
    for _ in range(4):  # 15 digits, doubled four times
        t_max -= rate(t_max) / rate_slope(t_max)
    return Truth(force(sample, t_max), t_max)


def derivatives(sample: Sample, scales: Sample) -> tuple[np.ndarray, np.ndarray]:
    """Gradient (2, 6) and Hessian (2, 6, 6) of F_max and t_max, by central differences.

    The steps are 1e-12 of `scales`: with 60 digits neither rounding nor truncation reaches float64.
    """
    steps = [mp.mpf(scale) * mp.mpf(10) ** -12 for scale in scales]

    def at(*moves: tuple[int, int]) -> mp.matrix:
        point = [mp.mpf(x) for x in sample]
        for index, sign in moves:
            point[index] += sign * steps[index]
        result = peak(tuple(point))  # type: ignore[arg-type]
        assert result is not None
        return mp.matrix(result)

    n = len(sample)
    centre = at()
    gradient, hessian = np.zeros((2, n)), np.zeros((2, n, n))
    for i in range(n):
        up, down = at((i, 1)), at((i, -1))
        gradient[:, i] = list((up - down) / (2 * steps[i]))
        hessian[:, i, i] = list((up - 2 * centre + down) / steps[i] ** 2)
        for j in range(i):
            same, opposite = (
                at((i, 1), (j, 1)) + at((i, -1), (j, -1)),
                at((i, 1), (j, -1)) + at((i, -1), (j, 1)),
            )
            hessian[:, i, j] = hessian[:, j, i] = list((same - opposite) / (4 * steps[i] * steps[j]))
    return gradient, hessian


def wide_box(size: int, seed: int) -> np.ndarray:
    """Random samples of the box the accuracy is promised in, shape (size, 6)."""
    random = np.random.default_rng(seed)

    def log_uniform(low: float, high: float) -> np.ndarray:
        return np.exp(random.uniform(np.log(low), np.log(high), size))

    m, k_c, v = log_uniform(0.5, 10), log_uniform(1e4, 1e6), log_uniform(0.01, 1)
    k_f, zeta, f_p = random.uniform(0, 1e4, size), random.uniform(0, 1.5, size), random.uniform(0, 500, size)
    return np.stack([m, 2 * zeta * np.sqrt(m * (k_f + k_c)), k_f, k_c, v, f_p], axis=1)

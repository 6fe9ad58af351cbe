"""What free curves share: how they go on beyond the trials, dynamics through which they see a force, their starts."""

import functools
from collections.abc import Callable, Mapping, Sequence

import jax.numpy as jnp

from acf_jax.effects._interface import Scalar


def continued(
    curve: Callable[[Scalar], Scalar], u: Scalar, reach: Scalar, over: Sequence[float], steepest: float
) -> Scalar:
    """A free curve g(u), straight above the reach: a polynomial beyond what it was fitted to says nothing.

    The slope is the least of the mean ones `over` these last shares of the tried range, within -1 (u + g(u) does not
    fall) and `steepest`.
    """
    tried = jnp.minimum(u, reach)
    end = jnp.where(jnp.isfinite(reach), reach, 1.0)
    slopes = [(curve(end) - curve((1 - share) * end)) / (share * end) for share in over]
    slope = functools.reduce(jnp.minimum, slopes)
    return curve(tried) + jnp.clip(slope, -1.0, steepest) * (u - tried)


def passing(
    force: Scalar, y: Scalar, y_dot: Scalar, frequency_hz: Scalar, damping_ratio: Scalar
) -> tuple[Scalar, Scalar]:
    """Rates (y', y'') of y'' + 2 zeta omega y' + omega^2 y = omega^2 F."""
    omega = 2 * jnp.pi * frequency_hz
    return (y_dot, omega**2 * (force - y) - 2 * damping_ratio * omega * y_dot)


def beginning(starts: Sequence[Mapping[str, float]]) -> Callable[..., tuple[float, ...]]:
    """What gives a parameter its starts: `of(name, usual)` is its value at each, `usual` where that names none."""

    def of(name: str, usual: float = 0.0) -> tuple[float, ...]:
        return tuple(start.get(name, usual) for start in starts)

    return of

"""Sensors that follow the force as a damped oscillator does, and one exact step of it."""

import abc

import jax.numpy as jnp
from jaxtyping import Array, Float

from acf_jax.effects._interface import AbstractEffect, Scalar


class AbstractOscillator(AbstractEffect):
    """A sensor with a mode: where another law of a mode fits well, this one may as well."""

    component = "sensor"
    n_memory = 2

    @abc.abstractmethod
    def mode(self) -> tuple[Scalar, Scalar]:
        """Natural frequency omega, rad/s, and damping ratio zeta."""

    @staticmethod
    @abc.abstractmethod
    def of_mode(omega: float, zeta: float) -> tuple[float, ...]:
        """Parameters, in their order, with which a fit begins at a mode."""


def follow(
    f: tuple[Scalar, Scalar], h: Scalar, omega: Scalar, zeta: Scalar, state: Float[Array, " 2"]
) -> Float[Array, " 2"]:
    """y'' + 2 zeta omega y' + omega^2 y = omega^2 f over a step in which f is linear; (y, y') in and out.

    Exact for every damping (Nigam and Jennings, Bull. Seismol. Soc. Am. 59, 1969), with one formula for both sides of
    critical damping: e^{-zeta omega h} cos and sin continue into the exponentials of the two real roots.
    """
    slope = (f[1] - f[0]) / h
    lag = 2 * zeta / omega  # of the steady answer behind a ramp
    y, y_dot = state[0] - f[0] + lag * slope, state[1] - slope
    square = (1 - zeta**2) * (omega * h) ** 2
    size = jnp.sqrt(jnp.abs(square) + 1e-12)
    decay = zeta * omega * h
    slow, fast = jnp.exp(size - decay), jnp.exp(-size - decay)
    oscillates = square > 0
    cos = jnp.where(oscillates, jnp.exp(-decay) * jnp.cos(size), (slow + fast) / 2)
    sin = h / size * jnp.where(oscillates, jnp.exp(-decay) * jnp.sin(size), (slow - fast) / 2)
    swing = y_dot + zeta * omega * y
    y_new = y * cos + swing * sin
    y_dot_new = y_dot * cos - (omega**2 * y + zeta * omega * y_dot) * sin
    return jnp.stack([y_new + f[1] - lag * slope, y_dot_new + slope])

"""Dynamics through which a port sees a force."""

import jax.numpy as jnp

from acf_jax.effects._interface import Scalar


def passing(force: Scalar, y: Scalar, y_dot: Scalar, frequency_hz: Scalar, damping_ratio: Scalar) -> Scalar:
    """Rates (y', y'') of y'' + 2 zeta omega y' + omega^2 y = omega^2 F."""
    omega = 2 * jnp.pi * frequency_hz
    return jnp.stack([y_dot, omega**2 * (force - y) - 2 * damping_ratio * omega * y_dot])

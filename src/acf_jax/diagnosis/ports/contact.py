import jax.numpy as jnp

from acf_jax.effects import AbstractEffect, Motion, strength
from acf_jax.effects._interface import Scalar

S_0, V_0 = 1e-3, 0.1  # m, m/s: an impact's typical compression and its rate


class UnknownContact(AbstractEffect):
    """A contact force as a free function of compression and its rate: polynomial terms and their products."""

    component = "contact"
    title = "Unknown cause at the contact"

    root_n: Scalar = strength("N", -5e3, 5e3, (1.0,), 20.0, "at 1 mm, with the root of the compression")
    square_n: Scalar = strength("N", -5e3, 5e3, (1.0,), 20.0, "at 1 mm, with the square of the compression")
    cube_n: Scalar = strength("N", -5e3, 5e3, (0.0,), 20.0, "at 1 mm, with the cube of the compression")
    rate_n: Scalar = strength("N", -5e3, 5e3, (1.0,), 10.0, "at 0.1 m/s, with the rate")
    rate_2_n: Scalar = strength("N", -5e3, 5e3, (0.0,), 10.0, "at 0.1 m/s, with the square of the rate")
    dry_n: Scalar = strength("N", -500.0, 500.0, (0.0,), 10.0, "with the sign of the rate, growing to 1 mm")
    product_n: Scalar = strength(
        "N", -5e3, 5e3, (0.0,), 10.0, "at 1 mm and 0.1 m/s, with rate times compression"
    )

    def contact_force(self, motion: Motion, own: Scalar) -> Scalar:
        s, v = motion.s / S_0, motion.s_dot / V_0
        size = jnp.sqrt(s**2 + 1e-6)
        elastic = s * (self.root_n / jnp.sqrt(size) + self.square_n * size + self.cube_n * size**2)
        viscous = self.rate_n * v + self.rate_2_n * v * jnp.abs(v) + self.product_n * v * size
        return elastic + viscous + self.dry_n * jnp.tanh(v / 0.05) * jnp.tanh(size)

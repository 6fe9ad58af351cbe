import equinox as eqx
import jax.numpy as jnp

from acf_jax.diagnosis.ports._continued import continued
from acf_jax.effects import AbstractEffect, Motion, strength
from acf_jax.effects._interface import Scalar

F_0, V_0 = 100.0, 0.1  # N, m/s: an impact's typical force and rate of compression
WIDTH = 50.0  # N, within which a step of the contact's law happens
LAST = (0.2,)  # share of the tried range whose slope goes on beyond it
STEEPEST = 5.0  # N in addition for each newton of the linear contact beyond the reach


class UnknownContact(AbstractEffect):
    """A contact force as a free function of the linear contact's force and of the rate of compression.

    F = u + g(u) - g(u_0) with u = k_C s + u_0 and u_0 the force at first contact; g has polynomials and steps. Terms of
    the rate come in addition. Above the reach g goes on straight, not falling faster than u grows: a polynomial
    beyond the forces that it was fitted to says nothing.
    """

    component = "contact"
    title = "Unknown cause at the contact"

    square_n: Scalar = strength("N", -5e3, 5e3, (1.0,), 10.0, "at 100 N, with the square of the force")
    cube_n: Scalar = strength("N", -5e3, 5e3, (0.0,), 5.0, "at 100 N, with the cube of the force")
    step_100_n: Scalar = strength("N", -5e3, 5e3, (1.0,), 10.0, "half a step at 100 N")
    step_175_n: Scalar = strength("N", -5e3, 5e3, (0.0,), 10.0, "half a step at 175 N")
    step_250_n: Scalar = strength("N", -5e3, 5e3, (0.0,), 10.0, "half a step at 250 N")
    rate_n: Scalar = strength("N", -5e3, 5e3, (1.0,), 10.0, "at 0.1 m/s, with the rate")
    rate_2_n: Scalar = strength("N", -5e3, 5e3, (0.0,), 10.0, "at 0.1 m/s, with the square of the rate")
    dry_n: Scalar = strength("N", -500.0, 500.0, (0.0,), 5.0, "with the sign of the rate, at 100 N")
    product_n: Scalar = strength("N", -5e3, 5e3, (0.0,), 5.0, "at 100 N and 0.1 m/s, with rate times force")

    reach: Scalar = eqx.field(converter=jnp.asarray, default=jnp.inf)  # N, largest u that was tried

    def contact_force(self, motion: Motion, own: Scalar) -> Scalar:
        v = motion.s_dot / V_0
        u_0 = motion.f_0
        u = motion.rig.k_c * motion.s + u_0
        elastic = continued(self._elastic, u, self.reach, LAST, STEEPEST) - self._elastic(u_0)
        size = jnp.maximum(u, 0.0) / F_0
        viscous = self.rate_n * v + self.rate_2_n * v * jnp.abs(v) + self.product_n * v * size
        return elastic + viscous + self.dry_n * jnp.tanh(v / 0.05) * jnp.minimum(size, 1.0)

    def _elastic(self, u: Scalar) -> Scalar:
        polynomial = self.square_n * u * jnp.abs(u) / F_0**2 + self.cube_n * (u / F_0) ** 3
        steps = ((100.0, self.step_100_n), (175.0, self.step_175_n), (250.0, self.step_250_n))
        return polynomial + sum(size * jnp.tanh((u - centre) / WIDTH) for centre, size in steps)

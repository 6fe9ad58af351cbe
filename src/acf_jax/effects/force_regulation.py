import jax.numpy as jnp

from acf_jax.effects._interface import AbstractEffect, Motion, Scalar, strength


class ForceRegulation(AbstractEffect):
    """The pneumatic force control acts within the impact: a force R opposes the pretension, R' = omega_r (F_P - R).

    A first-order lag of the pressure loop with bandwidth omega_r / 2 pi; omega_r = 0 is the paper's model, whose
    control is 'much slower than the force response'.
    """

    component = "actuator"
    title = "Force regulation"
    n_own = 1

    bandwidth_hz: Scalar = strength("Hz", 0.0, 200.0, (1.0, 10.0), 10.0, "bandwidth of the force control")

    def force_on_mass(self, motion: Motion, own: Scalar) -> Scalar:
        return -own[0]

    def rates(self, motion: Motion, x_ddot: Scalar, own: Scalar) -> Scalar:
        return 2 * jnp.pi * self.bandwidth_hz * (motion.impact.f_p - own)

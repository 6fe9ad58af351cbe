import jax.numpy as jnp

from acf_jax.effects._interface import AbstractEffect, Motion, Scalar, States, shape, strength


class CoulombFriction(AbstractEffect):
    """Dry friction of guide and seals against the motion: F_f = -F_c tanh(w) - F_st w / (w^2/4 + 3/4)^2, w = x'/v_s.

    Coulomb's law and Stribeck's extra force at low speed, both regularised over the transition velocity v_s; Brown and
    McPhee, 'A continuous velocity-based friction model', J. Comput. Nonlinear Dyn. 11 (2016).
    """

    component = "actuator"
    title = "Dry friction"
    remedy = "clean and lubricate the guide, and check the seals and the alignment of the flange"

    force_n: Scalar = strength("N", 0.0, 200.0, (3.0, 25.0), 20.0, "sliding friction F_c")
    stribeck_n: Scalar = strength(
        "N", 0.0, 200.0, (0.3, 1.0), 7.0, "extra friction F_st at the transition velocity"
    )
    transition_velocity_m_per_s: Scalar = shape("m/s", 1e-3, 0.3, (0.01, 0.03), "speed v_s of full sliding")

    def force_on_mass(self, motion: Motion, state: States) -> Scalar:
        w = motion.x_dot / self.transition_velocity_m_per_s
        return -self.force_n * jnp.tanh(w) - self.stribeck_n * w / (0.25 * w**2 + 0.75) ** 2

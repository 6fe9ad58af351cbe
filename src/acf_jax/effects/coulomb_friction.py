import jax.numpy as jnp

from acf_jax.effects._interface import AbstractEffect, Motion, Scalar, States, shape, strength


class CoulombFriction(AbstractEffect):
    """Dry friction of guide and seals against the motion: F_f = -(F_c + mu F_P) tanh(x'/v_s).

    Coulomb's law, regularised over the transition velocity v_s: seals creep before they slide. The pressure that makes
    F_P presses them on: in public measurements of printed cylinders (Zillen, TU Delft) mu is 0.018 to 0.034. Andersson,
    Soderberg and Bjorklund, 'Friction models for sliding dry, boundary and mixed lubricated contacts', Tribology
    International 40 (2007).
    """

    component = "actuator"
    title = "Dry friction"
    remedy = "clean and lubricate the guide, and check the seals and the alignment of the flange"

    force_n: Scalar = strength("N", 0.0, 200.0, (3.0, 25.0), 20.0, "sliding friction F_c without pretension")
    coefficient: Scalar = strength(
        "1", 0.0, 1.0, (0.005, 0.05), 0.05, "friction mu for each newton of pretension"
    )
    transition_velocity_m_per_s: Scalar = shape("m/s", 1e-3, 0.3, (0.01, 0.03), "speed v_s of full sliding")

    def force_on_mass(self, motion: Motion, state: States) -> Scalar:
        sliding = self.force_n + self.coefficient * motion.impact.f_p
        return -sliding * jnp.tanh(motion.x_dot / self.transition_velocity_m_per_s)

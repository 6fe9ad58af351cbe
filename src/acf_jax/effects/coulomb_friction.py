import jax.numpy as jnp

from acf_jax.effects._interface import AbstractEffect, Motion, Scalar, shape, strength

V_S = 2e-3  # m/s; below it the friction is taken as viscous, which keeps the equation of motion smooth


class CoulombFriction(AbstractEffect):
    """Dry friction of guide and seals against the motion: F_f = -(F_c + (F_s - F_c) e^{-(x'/v_st)^2}) tanh(x'/v_s).

    Coulomb's law with Stribeck's extra force at low speed, regularised; Olsson et al., 'Friction models and friction
    compensation', Eur. J. Control 4 (1998).
    """

    component = "actuator"
    title = "Dry friction"

    force_n: Scalar = strength("N", 0.0, 200.0, (3.0, 25.0), 20.0, "sliding friction F_c")
    stribeck_n: Scalar = strength("N", 0.0, 200.0, (1.0, 8.0), 7.0, "extra friction F_s - F_c at low speed")
    stribeck_velocity_m_per_s: Scalar = shape(
        "m/s", 5e-3, 0.5, (0.05,), "speed v_st at which the extra fades"
    )

    def force_on_mass(self, motion: Motion, own: Scalar) -> Scalar:
        fading = jnp.exp(-((motion.x_dot / self.stribeck_velocity_m_per_s) ** 2))
        return -(self.force_n + self.stribeck_n * fading) * jnp.tanh(motion.x_dot / V_S)

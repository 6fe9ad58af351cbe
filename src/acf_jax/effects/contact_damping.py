import jax.numpy as jnp

from acf_jax.effects._interface import AbstractEffect, Motion, Scalar, States, strength


class ContactDamping(AbstractEffect):
    """The pad dissipates: F_C = F_el + (c + chi F_el / k_C + c_2 |s'|) s', F_el = k_C s + F_C(0).

    chi = 0 is Kelvin-Voigt, c = 0 Hunt-Crossley with chi in N s/m^2 ('Coefficient of restitution interpreted as
    damping in vibroimpact', J. Appl. Mech. 42, 1975): dissipation in proportion to the whole compression, that of the
    pretension included. c_2 is what a fluid adds that is squeezed through the pad's pores fast: Forchheimer's term
    (Nield and Bejan, 'Convection in Porous Media', ch. 1).
    """

    component = "contact"
    title = "Contact damping"
    remedy = "use a pad that damps less, or accept the force: it grows with speed"

    damping_n_s_per_m: Scalar = strength("N s/m", 0.0, 5e3, (30.0, 200.0), 150.0, "Kelvin-Voigt damping")
    hunt_crossley_n_s_per_m2: Scalar = strength(
        "N s/m^2", 0.0, 5e6, (3e4, 3e5), 1.5e5, "damping per compression"
    )
    quadratic_n_s2_per_m2: Scalar = strength(
        "N s^2/m^2", 0.0, 2e4, (0.0, 300.0), 500.0, "damping in proportion to the squared velocity"
    )

    def contact_force(self, motion: Motion, state: States) -> Scalar:
        compression = jnp.maximum(motion.s + motion.f_0 / motion.rig.k_c, 0.0)
        damping = self.damping_n_s_per_m + self.hunt_crossley_n_s_per_m2 * compression
        return (damping + self.quadratic_n_s2_per_m2 * jnp.abs(motion.s_dot)) * motion.s_dot

import jax.numpy as jnp

from acf_jax.effects._interface import AbstractEffect, Motion, Scalar, strength

F_0 = 100.0  # N; at this force the contact has the stiffness k_C of the rig
S_0 = 1e-3  # m; unit of compression of the pad's own gain


class ContactHardening(AbstractEffect):
    """The contact spring stiffens: a power law of the whole compression, and a pad that hardens from first contact.

    F_C = F_0 ((F_P/F_0)^(1/n) + k_C s / (n F_0))^n + beta k_C s |s| / s_0, with n = 1 + excess: the tangent stiffness
    grows as F^(1 - 1/n) and is k_C at F_0 = 100 N. n = 1.5 is Hertz' contact (Johnson, 'Contact Mechanics', ch. 4).
    """

    component = "contact"
    title = "Hardening contact"

    exponent_excess: Scalar = strength("1", -0.4, 3.0, (0.1, 0.5), 0.3, "exponent of the force law less one")
    gain: Scalar = strength("1", -0.9, 20.0, (0.0, 0.0), 0.2, "relative gain of the pad's force at 1 mm")

    def contact_force(self, motion: Motion, own: Scalar) -> Scalar:
        n = 1 + self.exponent_excess
        k_c, s, f_p = motion.rig.k_c, motion.s, motion.impact.f_p
        # where contact is lost the base is negative: it is kept positive, and far from there untouched
        base = (jnp.maximum(f_p, 1e-3) / F_0) ** (1 / n) + k_c * s / (n * F_0)
        power = F_0 * jnp.maximum(base, 1e-6) ** n
        return power - f_p - k_c * s + self.gain * k_c * s * jnp.abs(s) / S_0

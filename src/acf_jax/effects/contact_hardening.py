import jax.numpy as jnp

from acf_jax.effects._interface import AbstractEffect, Motion, Scalar, shape, strength

F_0 = 100.0  # N; at this force the contact has the stiffness k_C of the rig
S_0 = 1e-3  # m; unit of compression of the pad's own gain
TINY = 1e-12  # the power law has no slope at zero


class ContactHardening(AbstractEffect):
    """The contact spring stiffens: a power law of the whole compression, and a pad that hardens from first contact.

    F_C = F_0 b^n + beta k_C s |s/s_0|^q, b = (F_C(0)/F_0)^(1/n) + k_C s / (n F_0), with n = 1 + excess: the tangent
    stiffness grows as F^(1 - 1/n) and is k_C at F_0 = 100 N. n = 1.5 is Hertz' contact (Johnson, 'Contact Mechanics',
    Cambridge, 1985, ch. 4); q = 2 is a rubber pad's cubic term, more a foam that densifies (Gibson and Ashby, 'Cellular
    Solids', 1997, ch. 5).
    """

    component = "contact"
    title = "Hardening contact"

    exponent_excess: Scalar = strength(
        "1", -0.4, 3.0, (0.1, 0.5, 0.05), 0.3, "exponent of the force law less one"
    )
    gain: Scalar = strength("1", -0.9, 20.0, (0.0, 0.0, 0.1), 0.2, "relative gain of the pad's force at 1 mm")
    pad_exponent: Scalar = shape("1", 0.7, 5.0, (1.5, 1.5, 2.0), "exponent q of that gain")

    def contact_force(self, motion: Motion, own: Scalar) -> Scalar:
        n = 1 + self.exponent_excess
        k_c, s, f_0 = motion.rig.k_c, motion.s, motion.f_0
        base = (jnp.maximum(f_0, TINY) / F_0) ** (1 / n) + k_c * s / (n * F_0)
        # an odd law: it continues beyond the loss of contact, where n = 1 has to be the paper's two-sided spring
        power = F_0 * jnp.sign(base) * jnp.maximum(jnp.abs(base), TINY) ** n
        return (
            power
            - f_0
            - k_c * s
            + self.gain * k_c * s * (jnp.sqrt(s**2 + TINY**2) / S_0) ** self.pad_exponent
        )

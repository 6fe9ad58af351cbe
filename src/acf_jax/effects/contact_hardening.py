import math
from functools import partial

import jax
import jax.numpy as jnp

from acf_jax.effects._interface import AbstractEffect, Motion, Scalar, States, shape, strength
from acf_jax.model import Rig

F_0 = 100.0  # N; at this force the power law has the stiffness k_C of the rig
S_0 = 1e-3  # m; unit of compression of the pad's own gain
LEAST = 1e-6  # N, of the force at first contact
TINY = 1e-15  # m; a power law has no slope at zero
NEWTON_STEPS = 6  # from at most twice the solution


class ContactHardening(AbstractEffect):
    """The contact spring stiffens with its whole compression S: a power law, and a pad that hardens.

    F_C = F_0 (k_C S / (n F_0))^n + beta k_C S |S/s_0|^q, S = S(0) + s with F_C = F_C(0) at S(0), as Eq. (2)'s s_0 of
    the linear spring, n = 1 + excess. The power law's stiffness grows as F^(1 - 1/n) and is k_C at F_0 = 100 N.
    n = 1.5 is Hertz' contact (Johnson, 'Contact Mechanics', Cambridge, 1985, ch. 4); q = 2 is a rubber pad's cubic
    term, more a foam that densifies (Gibson and Ashby, 'Cellular Solids', 1997, ch. 5).
    """

    component = "contact"
    title = "Hardening contact"
    remedy = "touch down slower or use a thicker pad: it stiffens as it is compressed"

    exponent_excess: Scalar = strength(
        "1", -0.4, 3.0, (0.1, 0.5, 0.05), 0.3, "exponent of the force law less one"
    )
    gain: Scalar = strength("1", 0.0, 20.0, (0.0, 0.0, 0.1), 0.2, "relative gain of the pad's force at 1 mm")
    pad_exponent: Scalar = shape("1", 0.7, 5.0, (1.5, 1.5, 2.0), "exponent q of that gain", needs=("gain",))

    def contact_force(self, motion: Motion, state: States) -> Scalar:
        f_0 = jnp.maximum(motion.f_0, LEAST)
        compression = self._at_rest(motion.rig, f_0) + motion.s
        return self._law(motion.rig, compression) - f_0 - motion.rig.k_c * motion.s

    def _law(self, rig: Rig, compression: Scalar) -> Scalar:
        """Force of a compression, an odd law: beyond the loss of contact the paper's spring is two-sided, too."""
        n, log_size = 1 + self.exponent_excess, 0.5 * jnp.log(compression**2 + TINY**2)
        # of powers by exp and log a compiler computes many at once, with their derivatives
        power = F_0 * jnp.exp(n * (log_size + jnp.log(rig.k_c / (n * F_0))))
        stiffer = jnp.exp(self.pad_exponent * (log_size - math.log(S_0)))
        return jnp.sign(compression) * power + self.gain * rig.k_c * compression * stiffer

    def _at_rest(self, rig: Rig, f_0: Scalar) -> Scalar:
        """The compression under the force f_0, by Newton's method from what either term alone would need."""
        n = 1 + self.exponent_excess
        of_power = n * F_0 / rig.k_c * (f_0 / F_0) ** (1 / n)
        of_pad = S_0 * (f_0 / (jnp.maximum(self.gain, 1e-12) * rig.k_c * S_0)) ** (
            1 / (1 + self.pad_exponent)
        )

        def step(_: int, compression: Scalar) -> Scalar:
            law, along = partial(self._law, rig), jnp.ones_like(compression)
            force, slope = jax.jvp(law, (compression,), (along,))
            return compression - (force - f_0) / slope

        return jax.lax.fori_loop(0, NEWTON_STEPS, step, jnp.minimum(of_power, of_pad))

import jax.numpy as jnp

from acf_jax.effects._interface import AbstractEffect, Motion, Scalar, shape, strength


class PadRelaxation(AbstractEffect):
    """The pad is viscoelastic: a Maxwell branch beside the spring, F_C = F_P + k_C s + q, q' = k_1 s' - q/tau.

    Where the pretension was set just before, it still relaxes as well: by the share p F_P (1 - exp(-t/tau)).
    Standard linear solid with relaxed stiffness k_C; Lakes, 'Viscoelastic Materials' (Cambridge, 2009), ch. 2.
    """

    component = "contact"
    title = "Relaxing pad"
    n_own = 1

    stiffness_ratio: Scalar = strength("1", 0.0, 8.0, (0.1, 0.6), 0.5, "k_1 / k_C")
    preload_share: Scalar = strength("1", 0.0, 1.0, (0.0, 0.1), 0.1, "share p of the pretension that relaxes")
    relaxation_time_s: Scalar = shape("s", 3e-4, 0.1, (1e-3, 5e-3), "time constant tau")

    def contact_force(self, motion: Motion, own: Scalar) -> Scalar:
        faded = 1 - jnp.exp(-motion.t / self.relaxation_time_s)
        return own[0] - self.preload_share * motion.impact.f_p * faded

    def rates(self, motion: Motion, x_ddot: Scalar, own: Scalar) -> Scalar:
        return self.stiffness_ratio * motion.rig.k_c * motion.s_dot - own / self.relaxation_time_s

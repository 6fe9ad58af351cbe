import jax.numpy as jnp

from acf_jax.effects._interface import AbstractEffect, Motion, Scalar, States, shape, strength


class PadRelaxation(AbstractEffect):
    """The pad is viscoelastic: a share a of its stiffness relaxes, F_C = F_P + k_C (s - a z), z' = (s - z)/tau.

    k_C is the stiffness that an impact meets, k_C (1 - a) what is left of it under a lasting load. Where the pretension
    was set just before, it still relaxes as well: by the share p F_P (1 - exp(-t/tau)).
    Standard linear solid; Lakes, 'Viscoelastic Materials' (Cambridge, 2009), ch. 2.
    """

    component = "contact"
    title = "Relaxing pad"
    remedy = "leave the same pause between contacts, or use a pad that relaxes less"
    n_state = 1

    stiffness_share: Scalar = strength("1", 0.0, 0.9, (0.1, 0.4), 0.3, "share a of k_C that relaxes")
    preload_share: Scalar = strength("1", 0.0, 1.0, (0.0, 0.1), 0.1, "share p of the pretension that relaxes")
    relaxation_time_s: Scalar = shape("s", 3e-4, 0.1, (1e-3, 5e-3), "time constant tau")

    def contact_force(self, motion: Motion, state: States) -> Scalar:
        faded = 1 - jnp.exp(-motion.t / self.relaxation_time_s)
        relaxed = self.stiffness_share * motion.rig.k_c * state[0]
        return -relaxed - self.preload_share * motion.impact.f_p * faded

    def rates(self, motion: Motion, x_ddot: Scalar, state: States) -> States:
        return ((motion.s - state[0]) / self.relaxation_time_s,)

import jax.numpy as jnp

from acf_jax.effects._interface import AbstractEffect, Motion, Scalar, States, shape, strength


class PadBottoming(AbstractEffect):
    """The pad bottoms out: beyond a compression it is stiffer, F_C = k_C S + k_b (S - s_b)+ of the whole compression S.

    S = S(0) + s with F_C = F_C(0) at S(0), as Eq. (2)'s s_0 of the linear spring: a pretension beyond k_C s_b presses
    the pad to its bottom before the impact. k_b = ratio k_C. A piecewise linear spring; Shaw and Holmes, 'A
    periodically forced piecewise linear oscillator', J. Sound Vib. 90 (1983). Foam that is pressed together becomes up
    to some ten times as stiff (Gibson and Ashby, 'Cellular Solids', 1997, ch. 5), a pad of a few millimetres on a plate
    more: the bound is what the simulation's step still resolves.
    """

    component = "contact"
    title = "Pad that bottoms out"
    remedy = "use a thicker or stiffer pad, or touch down slower: it is pressed to its bottom"
    longest_step = 5e-5  # at the corner of its law the method is of second order only

    stiffness_ratio: Scalar = strength(
        "1", 0.0, 100.0, (1.0, 8.0), 3.0, "stiffness k_b added beyond the compression, over k_C"
    )
    compression_m: Scalar = shape(
        "m", 1e-5, 0.05, (0.4, 0.55), "compression s_b at which the pad bottoms out", of="compression"
    )

    def contact_force(self, motion: Motion, state: States) -> Scalar:
        k_c, k_b, s_b = motion.rig.k_c, self.stiffness_ratio * motion.rig.k_c, self.compression_m
        at_rest = jnp.where(motion.f_0 > k_c * s_b, (motion.f_0 + k_b * s_b) / (k_c + k_b), motion.f_0 / k_c)
        beyond = jnp.maximum(at_rest + motion.s - s_b, 0.0) - jnp.maximum(at_rest - s_b, 0.0)
        return k_b * beyond

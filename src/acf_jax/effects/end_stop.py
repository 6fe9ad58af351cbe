import jax.numpy as jnp

from acf_jax.effects._interface import AbstractEffect, Motion, Scalar, States, strength
from acf_jax.model import Impact


class EndStop(AbstractEffect):
    """The flange rests on its stop, which holds a share of the pretension until the contact force exceeds F_P.

    F_C(0) = (1 - sigma) F_P; x = 0 while F_C < F_P; then m x'' + d x' + k_F x = F_C - sigma_o F_P. With sigma =
    sigma_o = 1, d = k_F = 0 the peak is F_P + v sqrt(k_C m). A preloaded unilateral stop: Brogliato, 'Nonsmooth
    Mechanics' (Springer, 3rd ed. 2016), ch. 1. No more opposes than was held: sigma_o > sigma counts as sigma. A stop
    that holds nothing and opposes would be the friction of seals under pressure.
    """

    component = "actuator"
    title = "End stop"
    remedy = "move the working point off the stop, and check what the stop holds before contact"

    share: Scalar = strength("1", 0.0, 1.0, (0.2, 0.9), 0.5, "share of the pretension that the stop holds")
    opposing_share: Scalar = strength(
        "1", 0.0, 1.0, (0.2, 0.9), 0.5, "share that opposes the motion afterwards", within="share"
    )

    def initial_relief(self, impact: Impact) -> Scalar:
        return self.share * impact.f_p

    def release_force(self, impact: Impact) -> Scalar:
        return jnp.where(self.share > 0, impact.f_p, -jnp.inf)

    def force_on_mass(self, motion: Motion, state: States) -> Scalar:
        return -jnp.minimum(self.opposing_share, self.share) * motion.impact.f_p

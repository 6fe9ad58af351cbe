import jax.numpy as jnp

from acf_jax.effects._interface import AbstractEffect, Motion, Scalar, States, shape, strength
from acf_jax.model import Impact


class PretensionError(AbstractEffect):
    """The pretension that acts is not the commanded one: F_0 = (1 + a) F_P + b, and nears F_P with the time T.

    F_C(0) = F_0 in place of F_P, and -(F_P - F_0) (1 - exp(-t/T)) on the mass: what is missing at first contact comes
    late, and a label that is simply wrong has a T far above the impact's. Regulators of pressure are off by some
    percent and some newtons; a force that is ramped up after first contact begins with a fraction of its label
    (Gadringer, Gattringer and Mueller, Mech. Sci. 13, 361, 2022: 10 N, and the rest within 0.1 s).
    """

    component = "actuator"
    title = "Wrong pretension"
    remedy = "hold the nominal pretension before contact, and check the regulator with a force gauge"

    share: Scalar = strength("1", -1.0, 1.0, (-0.05, -0.4), 0.2, "share a by which the pretension is off")
    offset_n: Scalar = strength("N", -100.0, 100.0, (1.0, 5.0), 10.0, "offset b of the pretension")
    rise_time_s: Scalar = shape(
        "s", 3e-3, 3.0, (0.3, 0.03), "time constant T; a chamber takes longer than its line, 3 ms"
    )

    def pretension_excess(self, impact: Impact) -> Scalar:
        return self.share * impact.f_p + self.offset_n

    def force_on_mass(self, motion: Motion, state: States) -> Scalar:
        missing = motion.label - motion.impact.f_p
        return missing * jnp.expm1(-motion.t / self.rise_time_s)

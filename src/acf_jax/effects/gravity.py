from acf_jax.effects._interface import AbstractEffect, Motion, Scalar, States, strength


class Gravity(AbstractEffect):
    """A constant force on the flange mass, m g sin(inclination) or any other bias of the actuator's force.

    m x'' + d x' + k_F x = F_C + F_g. The paper neglects gravitation (section 2).
    """

    component = "actuator"
    title = "Constant force on the flange (gravity)"
    remedy = "enter the tool's mass and the direction of the flange in the force controller"

    force_n: Scalar = strength("N", -150.0, 150.0, (5.0, -5.0), 20.0, "force in the direction of compression")

    def force_on_mass(self, motion: Motion, state: States) -> Scalar:
        return self.force_n

"""A body that recoils from the contact, as the simulator's effects see it."""

from acf_jax.effects import AbstractEffect, Motion, strength
from acf_jax.effects._interface import Scalar, States
from acf_jax.model import Impact, Rig


class Recoil(AbstractEffect):
    """The body is a free mass behind the contact: m_H y'' = F_C, and the contact is compressed by v t - x - y.

    Not a candidate of a diagnosis: a measuring stand does not recoil. ISO/TS 15066:2016, A.3.4 (two-body model).
    """

    component = "contact"
    title = "Recoiling body"
    n_state = 2

    inverse_mass_per_kg: Scalar = strength("1/kg", 0.0, 10.0, (0.1, 1.0), 1.0, "one over the body's mass")

    def robot_displacement(self, rig: Rig, impact: Impact, t: Scalar, state: States) -> tuple[Scalar, Scalar]:
        return -state[0], -state[1]

    def rates(self, motion: Motion, x_ddot: Scalar, state: States) -> States:
        return state[1], self.inverse_mass_per_kg * motion.f_c

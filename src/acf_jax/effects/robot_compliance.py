import jax.numpy as jnp

from acf_jax.effects._interface import AbstractEffect, Motion, Scalar, States, shape, strength
from acf_jax.model import Impact, Rig


class RobotCompliance(AbstractEffect):
    """The robot yields: a mass on a spring behind the contact, M (r'' + 2 zeta_r omega_r r' + omega_r^2 r) = -F_C.

    The robot's position is v t + r. The strength is 1/M, so that the rigid robot is its limit at zero. Haddadin et al.,
    'Robot collisions: a survey on detection, isolation, and identification', IEEE T-RO 33 (2017): reflected mass.
    """

    component = "robot"
    title = "Compliant robot"
    remedy = "touch the part in a stiffer pose of the robot, and check the flange's mounting for play"
    n_state = 2

    inverse_mass_per_kg: Scalar = strength(
        "1/kg", 0.0, 2.0, (0.01, 0.1, 0.4), 0.1, "one over the robot's mass"
    )
    frequency_hz: Scalar = shape("Hz", 2.0, 300.0, (15.0, 60.0, 40.0), "its natural frequency")
    damping_ratio: Scalar = shape("1", 0.01, 1.0, (0.1,), "its damping ratio zeta_r")

    def robot_displacement(self, rig: Rig, impact: Impact, t: Scalar, state: States) -> tuple[Scalar, Scalar]:
        return state[0], state[1]

    def rates(self, motion: Motion, x_ddot: Scalar, state: States) -> States:
        omega_r = 2 * jnp.pi * self.frequency_hz
        driven = -self.inverse_mass_per_kg * motion.f_c
        return state[1], driven - 2 * self.damping_ratio * omega_r * state[1] - omega_r**2 * state[0]

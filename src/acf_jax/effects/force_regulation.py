import jax.numpy as jnp

from acf_jax.effects._interface import AbstractEffect, Motion, Scalar, States, shape, strength


class ForceRegulation(AbstractEffect):
    """The pneumatic force control acts within the impact: -R on the mass, R' = omega_r (q - R), q' = omega_v (F_P - q).

    Two lags in series, the pressure in the chamber behind the valve and its line; omega_r = 0 is the paper's model,
    whose control is 'much slower than the force response'. Beater, 'Pneumatic Drives' (Springer, 2007), ch. 7.
    """

    component = "actuator"
    title = "Force regulation"
    remedy = "hold the pressure valve still during an impact and compare, or tune its regulator"
    n_state = 2

    bandwidth_hz: Scalar = strength(
        "Hz", 0.0, 200.0, (1.0, 10.0), 10.0, "bandwidth of the pressure, omega_r / 2 pi"
    )
    valve_hz: Scalar = shape("Hz", 5.0, 2000.0, (400.0, 60.0), "bandwidth of valve and line, omega_v / 2 pi")

    def force_on_mass(self, motion: Motion, state: States) -> Scalar:
        return -state[0]

    def rates(self, motion: Motion, x_ddot: Scalar, state: States) -> States:
        force, command = state
        return (
            2 * jnp.pi * self.bandwidth_hz * (command - force),
            2 * jnp.pi * self.valve_hz * (motion.impact.f_p - command),
        )

import jax.numpy as jnp

from acf_jax.effects._interface import AbstractEffect, Motion, Scalar, States, shape, strength


class PadMass(AbstractEffect):
    """A second mass (pad, backing plate) between contact and flange: m_p y'' = F_C - F_p, m x'' + ... = F_p.

    y = x + z, F_p = F_C(0) + k_p z + d_p z', omega_p^2 = k_p / m_p. Two-mass collision model; Stronge, 'Impact
    Mechanics' (Cambridge, 2000), ch. 7.
    """

    component = "contact"
    title = "Pad mass"
    remedy = "make what is in front of the pad lighter, or state its mass in the rig"
    longest_step = 5e-5  # a light pad rings at some kilohertz
    n_state = 2

    mass_kg: Scalar = strength("kg", 0.0, 3.0, (0.05, 0.1, 0.5), 0.3, "mass of the pad")
    frequency_hz: Scalar = shape(
        "Hz", 30.0, 6000.0, (1500.0, 150.0, 400.0), "its natural frequency on its own stiffness", looks=24
    )
    damping_ratio: Scalar = shape("1", 0.01, 0.5, (0.05,), "damping ratio of the pad on its stiffness")

    def pad_displacement(self, state: States) -> tuple[Scalar, Scalar]:
        return state[0], state[1]

    def _excess(self, state: States) -> Scalar:
        omega_p = 2 * jnp.pi * self.frequency_hz
        return self.mass_kg * (omega_p**2 * state[0] + 2 * self.damping_ratio * omega_p * state[1])

    def force_on_mass(self, motion: Motion, state: States) -> Scalar:
        pad_force = motion.f_0 + self._excess(state)
        return jnp.where(self.mass_kg > 0, pad_force - motion.f_c, 0.0)

    def rates(self, motion: Motion, x_ddot: Scalar, state: States) -> States:
        present = self.mass_kg > 0
        mass = jnp.where(present, self.mass_kg, 1.0)
        z_ddot = (motion.f_c - motion.f_0 - self._excess(state)) / mass - x_ddot
        return jnp.where(present, state[1], 0.0), jnp.where(present, z_ddot, 0.0)

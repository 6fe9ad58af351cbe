import jax.numpy as jnp

from acf_jax.effects._interface import Scalar, shape, strength
from acf_jax.effects._oscillator import AbstractOscillator, follow


class FixtureMass(AbstractOscillator):
    """A mass between contact and sensor rings on it: m_w w'' = F_C - k_w w - d_w w', and k_w w + d_w w' is read.

    Workpiece or plate on the sensor, d_w = tau_w k_w. The reading is the force less the inertia of that mass, so that
    it goes below zero where nothing pulls; traces tell the ratio of m_w and k_w only, which the prior of k_w turns into
    a mass: that of load cells and force-torque sensors on their mounting. Unlike `sensor_resonance` all force passes
    through the mode, and the damper's force is read, too. Maranzano and Hancock (2016); Machines 12(1), 26 (2024).
    """

    title = "Mass on the sensor"
    remedy = "make what lies on the sensor lighter, or bolt it to a stiffer sensor"
    longest_step = 5e-5  # all of the force rings: what lies between steps has to be told well

    mass_kg: Scalar = strength(
        "kg",
        0.0,
        50.0,
        (2.0, 2.0),
        2.0,
        "mass m_w between contact and sensor",
        looks=32,
        per="stiffness_n_per_m",
    )
    stiffness_n_per_m: Scalar = shape(
        "N/m", 1e6, 1e9, (3e7, 6e6), "stiffness k_w of the sensor and its mounting"
    )
    damping_time_s: Scalar = shape("s", 1e-6, 5e-4, (1e-5, 5e-5), "damping over stiffness, tau_w = d_w/k_w")

    def sense(self, f: tuple[Scalar, Scalar], h: Scalar, memory: Scalar) -> tuple[Scalar, Scalar]:
        # of one radian; far below a step it is not resolved, and nothing is left of it
        present = self.mass_kg > 0
        period = jnp.sqrt(jnp.where(present, self.mass_kg, 1.0) / self.stiffness_n_per_m)
        omega = 1 / jnp.maximum(period, 1e-3 * h)
        memory = follow(f, h, omega, self.damping_time_s * omega / 2, memory)
        return memory, jnp.where(present, memory[0] + self.damping_time_s * memory[1], f[1])

    def mode(self) -> tuple[Scalar, Scalar]:
        omega = jnp.sqrt(self.stiffness_n_per_m / self.mass_kg)
        return omega, self.damping_time_s * omega / 2

    @staticmethod
    def of_mode(omega: float, zeta: float) -> tuple[float, ...]:
        return 3e7 / omega**2, 3e7, 2 * zeta / omega

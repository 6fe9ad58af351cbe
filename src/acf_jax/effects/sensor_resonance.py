import jax.numpy as jnp

from acf_jax.effects._interface import Scalar, shape, strength
from acf_jax.effects._oscillator import AbstractOscillator, follow


class SensorResonance(AbstractOscillator):
    """A lightly damped mode of sensor and mounting: y'' + 2 zeta_s omega_s y' + omega_s^2 y = omega_s^2 F.

    The reading is (1 - share) F + share y: modes of much higher frequency pass their share of the force at once.
    Clough and Penzien, 'Dynamics of Structures' (2nd ed. 1993), ch. 3 and 12.
    """

    title = "Sensor resonance"
    remedy = "mount the sensor stiffer, and make what is bolted to it lighter"
    longest_step = 5e-5  # where all of the force rings, what lies between steps has to be told well

    share: Scalar = strength(
        "1", 0.0, 1.5, (0.2, 0.9), 0.7, "share of the force that passes through the mode"
    )
    frequency_hz: Scalar = shape("Hz", 40.0, 1e4, (250.0, 600.0, 1200.0), "natural frequency", looks=28)
    damping_ratio: Scalar = shape("1", 0.003, 0.15, (0.08, 0.04, 0.04), "damping ratio zeta_s")

    def sense(self, f: tuple[Scalar, Scalar], h: Scalar, memory: Scalar) -> tuple[Scalar, Scalar]:
        memory = follow(f, h, 2 * jnp.pi * self.frequency_hz, self.damping_ratio, memory)
        return memory, (1 - self.share) * f[1] + self.share * memory[0]

    def mode(self) -> tuple[Scalar, Scalar]:
        return 2 * jnp.pi * self.frequency_hz, self.damping_ratio

    @staticmethod
    def of_mode(omega: float, zeta: float) -> tuple[float, ...]:
        return 0.9, omega / (2 * jnp.pi), zeta

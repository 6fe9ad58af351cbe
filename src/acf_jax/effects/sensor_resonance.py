import jax.numpy as jnp

from acf_jax.effects._interface import Scalar, shape, strength
from acf_jax.effects._oscillator import AbstractOscillator, follow

SECOND = ("share_2",)


class SensorResonance(AbstractOscillator):
    """Lightly damped modes of sensor and mounting: y_i'' + 2 zeta_i omega_i y_i' + omega_i^2 y_i = omega_i^2 F.

    The reading is F + share (y_1 - F) + share_2 (y_2 - F): modes of much higher frequency pass their share of the force
    at once. Clough and Penzien, 'Dynamics of Structures' (2nd ed. 1993), ch. 3 and 12.
    """

    title = "Sensor resonance"
    form = 2
    remedy = "mount the sensor stiffer, and make what is bolted to it lighter"
    longest_step = 5e-5  # where all of the force rings, what lies between steps has to be told well
    n_memory = 4

    share: Scalar = strength(
        "1", 0.0, 1.5, (0.2, 0.9), 0.7, "share of the force that passes through the first mode"
    )
    share_2: Scalar = strength(
        "1", 0.0, 1.0, (0.0,), 0.2, "the same of the second mode", over=("frequency_ratio", 25)
    )
    frequency_hz: Scalar = shape(
        "Hz", 40.0, 1e4, (250.0, 600.0, 1200.0), "natural frequency of the first mode", looks=28
    )
    frequency_ratio: Scalar = shape(
        "1", 1.2, 4.0, (2.0,), "natural frequency of the second mode over that", needs=SECOND
    )
    damping_ratio: Scalar = shape(
        "1", 0.003, 0.15, (0.08, 0.04, 0.04), "damping ratio of the first mode", needs=("share",)
    )
    damping_ratio_2: Scalar = shape(
        "1", 0.003, 0.15, (0.02,), "damping ratio of the second mode", needs=SECOND
    )

    def sense(self, f: tuple[Scalar, Scalar], h: Scalar, memory: Scalar) -> tuple[Scalar, Scalar]:
        omega = 2 * jnp.pi * self.frequency_hz
        first = follow(f, h, omega, self.damping_ratio, memory[:2])
        second = follow(f, h, omega * self.frequency_ratio, self.damping_ratio_2, memory[2:])
        ringing = self.share * (first[0] - f[1]) + self.share_2 * (second[0] - f[1])
        return jnp.concatenate([first, second]), f[1] + ringing

    def mode(self) -> tuple[Scalar, Scalar]:
        return 2 * jnp.pi * self.frequency_hz, self.damping_ratio

    @staticmethod
    def of_mode(omega: float, zeta: float) -> tuple[float, ...]:
        return 0.9, 0.0, omega / (2 * jnp.pi), 2.0, zeta, 0.02

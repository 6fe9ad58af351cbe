import jax.numpy as jnp

from acf_jax.effects._interface import Scalar, shape, strength
from acf_jax.effects._oscillator import AbstractOscillator, follow


class SensorLag(AbstractOscillator):
    """Finite bandwidth of the force measurement, a well-damped low-pass: tau^2 y'' + 2 zeta_s tau y' + y = F.

    zeta_s = 0.7 is a second-order Butterworth filter, 1 two equal lags, 5 nearly a single lag of 2 zeta_s tau; Franklin
    et al., 'Digital Control of Dynamic Systems' (3rd ed. 1998), ch. 6.
    """

    title = "Sensor lag"
    remedy = "raise the cut-off frequency of the sensor's filter"
    delays = True

    time_constant_s: Scalar = strength("s", 0.0, 0.03, (1e-4, 5e-4), 5e-4, "time constant tau = 1/omega")
    damping_ratio: Scalar = shape("1", 0.4, 6.0, (0.8, 2.5), "damping ratio zeta_s")

    def sense(self, f: tuple[Scalar, Scalar], h: Scalar, memory: Scalar) -> tuple[Scalar, Scalar]:
        present = self.time_constant_s > 0
        tau = jnp.maximum(jnp.where(present, self.time_constant_s, 1.0), 1e-3 * h)
        memory = follow(f, h, 1 / tau, self.damping_ratio, memory)
        return memory, jnp.where(present, memory[0], f[1])

    def mode(self) -> tuple[Scalar, Scalar]:
        return 1 / self.time_constant_s, self.damping_ratio

    @staticmethod
    def of_mode(omega: float, zeta: float) -> tuple[float, ...]:
        return 1 / omega, zeta

from acf_jax.effects._interface import AbstractEffect, Scalar, strength


class SensorScale(AbstractEffect):
    """A gain error of the force measurement: F_s = (1 + g) F.

    The sensitivity of the transducer differs from its calibration; ISO 376:2011.
    """

    component = "sensor"
    title = "Sensor gain error"
    remedy = "check the sensor's gain with a known weight"

    gain_error: Scalar = strength("1", -0.5, 1.0, (0.03, -0.03), 0.1, "relative error g of the gain")

    def sense(self, f: tuple[Scalar, Scalar], h: Scalar, memory: Scalar) -> tuple[Scalar, Scalar]:
        return memory, (1 + self.gain_error) * f[1]

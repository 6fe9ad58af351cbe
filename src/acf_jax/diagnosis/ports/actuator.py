import jax.numpy as jnp

from acf_jax.effects import AbstractEffect, Motion, strength
from acf_jax.effects._interface import Scalar

X_0, V_0, T_0 = 1e-3, 0.1, 1e-2  # m, m/s, s: an impact's typical stroke, speed and duration


class UnknownActuator(AbstractEffect):
    """A force on the flange mass as a free function of its motion and of time: polynomial and dry-friction terms."""

    component = "actuator"
    title = "Unknown cause at the actuator"

    constant_n: Scalar = strength("N", -300.0, 300.0, (1.0,), 10.0, "constant")
    pretension_share: Scalar = strength("1", -2.0, 2.0, (0.02,), 0.15, "in proportion to the pretension")
    stroke_2_n: Scalar = strength("N", -2e3, 2e3, (1.0,), 15.0, "at 1 mm, with the square of the stroke")
    stroke_3_n: Scalar = strength("N", -2e3, 2e3, (0.0,), 15.0, "at 1 mm, with the cube of the stroke")
    near_n: Scalar = strength("N", -500.0, 500.0, (0.0,), 10.0, "with the stroke up to 0.3 mm")
    dry_n: Scalar = strength("N", -300.0, 300.0, (1.0,), 10.0, "with the sign of the speed")
    speed_2_n: Scalar = strength("N", -2e3, 2e3, (0.0,), 10.0, "at 0.1 m/s, with the square of the speed")
    growing_n: Scalar = strength("N", -2e3, 2e3, (0.0,), 10.0, "after 10 ms, with time")
    regulation_share: Scalar = strength("1", -5.0, 5.0, (0.0,), 0.15, "after 10 ms, with time and pretension")

    def force_on_mass(self, motion: Motion, own: Scalar) -> Scalar:
        x, v, t = motion.x / X_0, motion.x_dot / V_0, motion.t / T_0
        f_p = motion.impact.f_p
        of_stroke = (
            self.stroke_2_n * x * jnp.abs(x) + self.stroke_3_n * x**3 + self.near_n * jnp.tanh(x / 0.3)
        )
        of_speed = -self.dry_n * jnp.tanh(v / 0.02) - self.speed_2_n * v * jnp.abs(v)
        of_time = (self.growing_n + self.regulation_share * f_p) * t
        return self.constant_n + self.pretension_share * f_p + of_stroke + of_speed + of_time

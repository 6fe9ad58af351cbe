import jax.numpy as jnp

from acf_jax.effects import AbstractEffect, Motion, shape, strength
from acf_jax.effects._interface import Scalar
from acf_jax.model import Impact, Rig

T_0, F_0 = 1e-2, 100.0  # s, N: an impact's typical duration and force


class UnknownRobot(AbstractEffect):
    """A displacement of the robot as a free function of time, contact velocity and the contact force before.

    Polynomials, and a ripple of one frequency in phase with the contact.
    """

    component = "robot"
    title = "Unknown cause at the robot"
    n_own = 4

    time_2_m: Scalar = strength("m", -0.5, 0.5, (1e-5,), 1e-4, "after 10 ms, with the square of time")
    time_3_m: Scalar = strength("m", -0.5, 0.5, (0.0,), 1e-4, "after 10 ms, with the cube of time")
    speed_2: Scalar = strength(
        "1", -5.0, 5.0, (1e-2,), 0.1, "share of v t, after 10 ms, with the square of time"
    )
    yield_m: Scalar = strength("m", -0.05, 0.05, (1e-5,), 1e-4, "lagging 2 ms behind 100 N of contact force")
    slow_m: Scalar = strength("m", -0.5, 0.5, (0.0,), 1e-4, "after 10 ms of 100 N, with the impulse")
    inertia_m: Scalar = strength(
        "m", -0.5, 0.5, (0.0,), 1e-4, "after 10 ms of 100 N, with the second integral"
    )

    sine_m: Scalar = strength("m", -0.05, 0.05, (1e-6,), 2e-5, "ripple, sine")
    cosine_m: Scalar = strength("m", -0.05, 0.05, (0.0,), 2e-5, "ripple, cosine")
    ripple_hz: Scalar = shape("Hz", 20.0, 1000.0, (100.0, 300.0), "frequency of the ripple")

    def robot_displacement(self, rig: Rig, impact: Impact, t: Scalar, own: Scalar) -> tuple[Scalar, Scalar]:
        tau = t / T_0
        of_time = self.time_2_m * tau**2 + self.time_3_m * tau**3 + self.speed_2 * impact.v_e * t * tau
        w = 2 * jnp.pi * self.ripple_hz
        sine, cosine = jnp.sin(w * t), jnp.cos(w * t)
        ripple = self.sine_m * sine + self.cosine_m * (cosine - 1)
        ripple_rate = w * (self.sine_m * cosine - self.cosine_m * sine)
        rate = (
            2 * self.time_2_m * tau + 3 * self.time_3_m * tau**2 + 2 * self.speed_2 * impact.v_e * t
        ) / T_0
        lagged, impulse, second, lagged_rate = own
        of_force = -self.yield_m * lagged - self.slow_m * impulse - self.inertia_m * second
        force_rate = -self.yield_m * lagged_rate - self.inertia_m * impulse / T_0
        return of_time + of_force + ripple, rate + force_rate + ripple_rate

    def rates(self, motion: Motion, x_ddot: Scalar, own: Scalar) -> Scalar:
        force = motion.f_c / F_0
        lag = T_0 / 5 / 2  # two lags in series make a yield of 2 ms with a continuous rate
        lagged, impulse, _, lagged_rate = own
        lagged_ddot = (force - lagged - 2 * lag * lagged_rate) / lag**2
        return jnp.stack([lagged_rate, force / T_0, impulse / T_0, lagged_ddot])

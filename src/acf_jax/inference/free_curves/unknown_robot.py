import jax.numpy as jnp

from acf_jax.effects import AbstractEffect, Motion, shape, strength
from acf_jax.effects._interface import Scalar, States
from acf_jax.inference.free_curves._common import beginning, passing
from acf_jax.model import Impact, Rig

T_0, F_0 = 1e-2, 100.0  # s, N: an impact's typical duration and force
MOVING = {"time_2_m": 1e-5, "speed_2": 1e-2, "yield_m": 0.01, "sine_m": 1e-6, "frequency_hz": 3.0}
STARTS = (
    MOVING,
    MOVING | {"ripple_hz": 300.0},
    {"yield_m": 0.3, "frequency_hz": 1.0, "damping_ratio": 0.1},
    {"yield_m": 0.3, "frequency_hz": 0.3, "damping_ratio": 0.1},
    {"slow_m": 3e-4, "frequency_hz": 1.0},
    {"yield_m": 0.3, "yield_beyond_m": -3e-4, "frequency_hz": 3.0, "damping_ratio": 0.5},
    {"slow_beyond_m": 3e-4, "frequency_hz": 3.0},
    *(
        {"yield_m": 0.03, "play_n": play, "frequency_hz": frequency, "damping_ratio": 0.1}
        for play in (0.5, 2.0)
        for frequency in (2.0, 4.0)
    ),
)
_from = beginning(STARTS)
YIELDING = ("yield_m", "yield_beyond_m", "slow_m", "slow_beyond_m", "inertia_m")


class UnknownRobot(AbstractEffect):
    """A displacement of the robot as a free function of time, contact velocity and the contact force before.

    Polynomials from a time t_0 on, and a ripple of one frequency in phase with the contact. The force is seen through
    any second-order dynamics: the robot yields to it and goes on yielding, up to a level of it or from there on.
    """

    component = "robot"
    title = "Unknown cause at the robot"
    n_state = 5

    time_2_m: Scalar = strength(
        "m", -0.5, 0.5, _from("time_2_m"), 1e-4, "10 ms after t_0, with the square of time"
    )
    time_3_m: Scalar = strength("m", -0.5, 0.5, (0.0,), 1e-4, "10 ms after t_0, with the cube of time")
    speed_2: Scalar = strength(
        "1", -5.0, 5.0, _from("speed_2"), 0.1, "share of v t, 10 ms after t_0, with the square of time"
    )
    yield_m: Scalar = strength("m", -0.05, 0.05, _from("yield_m"), 1e-4, "under 100 N", of="compliance")
    yield_beyond_m: Scalar = strength(
        "m", -0.05, 0.05, _from("yield_beyond_m"), 1e-4, "under 100 N beyond a level"
    )
    slow_m: Scalar = strength("m", -0.5, 0.5, _from("slow_m"), 1e-4, "after 10 ms under 100 N")
    slow_beyond_m: Scalar = strength(
        "m", -0.5, 0.5, _from("slow_beyond_m"), 1e-4, "after 10 ms under 100 N beyond a level"
    )
    inertia_m: Scalar = strength(
        "m", -0.5, 0.5, (0.0,), 1e-4, "after 10 ms under 100 N, with the square of time"
    )
    play_n: Scalar = strength(
        "N",
        0.0,
        2e4,
        _from("play_n"),
        100.0,
        "of the yielding robot: under this force it yields as far",
        of="force",
        needs=YIELDING,
    )
    sine_m: Scalar = strength("m", -0.05, 0.05, _from("sine_m"), 2e-5, "ripple, sine")
    cosine_m: Scalar = strength("m", -0.05, 0.05, (0.0,), 2e-5, "ripple, cosine")

    ripple_hz: Scalar = shape(
        "Hz", 20.0, 1000.0, _from("ripple_hz", 100.0), "frequency of the ripple", needs=("sine_m", "cosine_m")
    )
    frequency_hz: Scalar = shape(
        "Hz",
        3.0,
        1500.0,
        _from("frequency_hz", 3.0),
        "natural frequency of the dynamics",
        of="frequency",
        needs=YIELDING,
    )
    damping_ratio: Scalar = shape(
        "1", 0.02, 3.0, _from("damping_ratio", 1.0), "their damping ratio", needs=YIELDING
    )
    level_n: Scalar = shape(
        "N", 10.0, 2e3, (0.5,), "that level", of="force", needs=("yield_beyond_m", "slow_beyond_m")
    )
    delay_s: Scalar = shape("s", 1e-5, 0.03, (1e-4,), "t_0", needs=("time_2_m", "time_3_m", "speed_2"))

    def robot_displacement(self, rig: Rig, impact: Impact, t: Scalar, state: States) -> tuple[Scalar, Scalar]:
        since = jnp.maximum(t - self.delay_s, 0.0)
        tau = since / T_0
        of_time = self.time_2_m * tau**2 + self.time_3_m * tau**3 + self.speed_2 * impact.v_e * since * tau
        time_rate = (
            2 * self.time_2_m * tau + 3 * self.time_3_m * tau**2 + 2 * self.speed_2 * impact.v_e * since
        ) / T_0
        w = 2 * jnp.pi * self.ripple_hz
        sine, cosine = _sine(w * t), _sine(w * t + jnp.pi / 2)
        ripple = self.sine_m * sine + self.cosine_m * (cosine - 1)
        ripple_rate = w * (self.sine_m * cosine - self.cosine_m * sine)
        seen, seen_rate, impulse, impulse_beyond, second = state
        beyond = self._beyond(seen)
        of_force = (
            self.yield_m * seen
            + self.yield_beyond_m * beyond
            + self.slow_m * impulse
            + self.slow_beyond_m * impulse_beyond
            + self.inertia_m * second
        )
        force_rate = (self.yield_m + self.yield_beyond_m * (beyond > 0)) * seen_rate + (
            self.slow_m * seen + self.slow_beyond_m * beyond + self.inertia_m * impulse
        ) / T_0
        return of_time + ripple - of_force, time_rate + ripple_rate - force_rate

    def rates(self, motion: Motion, x_ddot: Scalar, state: States) -> States:
        seen, seen_rate, impulse, *_ = state
        loose = jnp.clip(seen, 0.0, self.play_n / F_0)  # what the robot has moved of its play holds nothing
        rates = passing(motion.f_c / F_0 + loose, seen, seen_rate, self.frequency_hz, self.damping_ratio)
        return (*rates, seen / T_0, self._beyond(seen) / T_0, impulse / T_0)

    def _beyond(self, seen: Scalar) -> Scalar:
        return jnp.maximum(seen - self.level_n / F_0, 0.0)


def _sine(x: Scalar) -> Scalar:
    """sin x within 1e-9: a polynomial, which a compiler computes for many impacts at once."""
    turn = x - 2 * jnp.pi * jnp.round(x / (2 * jnp.pi))
    square, nested = turn**2, jnp.ones(())
    for k in range(20, 1, -2):
        nested = 1 - square / (k * (k + 1)) * nested
    return turn * nested

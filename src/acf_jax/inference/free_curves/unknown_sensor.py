import equinox as eqx
import jax.numpy as jnp

from acf_jax.effects import AbstractEffect, shape, strength
from acf_jax.effects._interface import Scalar
from acf_jax.effects._oscillator import follow
from acf_jax.inference.free_curves._common import beginning, continued

F_0 = 100.0  # N, an impact's typical force
LAST = (0.2, 0.01)  # shares of the tried range whose slope goes on: a sensor shows its limit at the very end
STEEPEST = 1.0  # N of reading in addition for each newton of force beyond the reach
KINKS = (0.1, 0.2, 0.35, 0.55, 0.75, 0.95)  # shares of the largest force where fits look for one
STARTS = (
    {"gain": 0.02, "lagging": 0.02},
    *({"beyond": 0.02, "level_n": share} for share in KINKS[:4]),
    *({"beyond": -0.9, "level_n": share} for share in KINKS[3:]),
    *({"sticking": 0.5, "play_n": share} for share in (0.08, 0.25)),
    {"lagging": 0.5, "frequency_hz": 60.0},
    *({"lagging": 0.5, "frequency_hz": hz, "damping_ratio": 0.05} for hz in (250.0, 600.0, 1200.0)),
)
_from = beginning(STARTS)
PASSED = ("lagging", "rate_s")  # what goes through dynamics


class UnknownSensor(AbstractEffect):
    """A reading as a free function of the force, its short past, its integral and its value at first contact.

    The function of the force is a polynomial with a kink, as where a sensor or its amplifier leaves its range. Above
    the reach it goes on straight, and the reading neither falls nor grows more than twice as fast as the force. The
    short past is seen through any second-order dynamics, from two lags to a resonance. A share of the reading may
    follow the force at a distance only, as with hysteresis.
    """

    component = "sensor"
    title = "Unknown cause at the sensor"
    delays = True
    n_memory = 5

    gain: Scalar = strength("1", -0.8, 3.0, _from("gain"), 0.1, "in proportion to the force")
    square_n: Scalar = strength("N", -500.0, 500.0, (0.0,), 5.0, "at 100 N, with the square of the force")
    cube_n: Scalar = strength("N", -500.0, 500.0, (0.0,), 3.0, "at 100 N, with the cube of the force")
    lagging: Scalar = strength("1", -2.0, 2.0, _from("lagging"), 0.2, "share that passes through dynamics")
    rate_s: Scalar = strength("s", -5e-3, 5e-3, (0.0,), 1e-4, "with the rate of change of what passed")
    drift_n: Scalar = strength("N", -500.0, 500.0, (0.0,), 5.0, "with the integral of the force, per 1 N s")
    offset_n: Scalar = strength("N", -200.0, 200.0, (0.0,), 2.0, "constant while in contact")
    sticking: Scalar = strength("1", -1.0, 1.0, _from("sticking"), 0.2, "share that follows at a distance")
    first: Scalar = strength("1", -2.0, 2.0, (0.0,), 0.05, "in proportion to the force at first contact")
    beyond: Scalar = strength(
        "1", -3.0, 3.0, _from("beyond"), 0.3, "in proportion to the force beyond a level"
    )

    level_n: Scalar = shape(
        "N", 10.0, 5e3, _from("level_n", 0.7), "that level", of="force", needs=("beyond",)
    )
    frequency_hz: Scalar = shape(
        "Hz", 20.0, 1e4, _from("frequency_hz", 300.0), "natural frequency of the dynamics", needs=PASSED
    )
    damping_ratio: Scalar = shape(
        "1", 0.005, 5.0, _from("damping_ratio", 1.0), "their damping ratio", needs=PASSED
    )
    play_n: Scalar = shape(
        "N", 0.5, 1e3, _from("play_n", 0.15), "distance at which it follows", of="force", needs=("sticking",)
    )

    reach: Scalar = eqx.field(converter=jnp.asarray, default=jnp.inf)  # N, largest force that was tried

    def sense(self, f: tuple[Scalar, Scalar], h: Scalar, memory: Scalar) -> tuple[Scalar, Scalar]:
        passed = follow(f, h, 2 * jnp.pi * self.frequency_hz, self.damping_ratio, memory[:2])
        impulse = memory[2] + h * (f[0] + f[1]) / 2
        static = continued(self._static, f[1], self.reach, LAST, STEEPEST)
        past = self.lagging * (passed[0] - f[1]) + self.rate_s * passed[1] + self.drift_n * impulse
        first = jnp.where(memory[3] == 0.0, f[1], memory[3])
        stuck = jnp.clip(memory[4], f[1] - self.play_n, f[1] + self.play_n)
        reading = f[1] + static + past + self.first * first + self.sticking * (stuck - f[1])
        return jnp.stack([*passed, impulse, first, stuck]), reading

    def _static(self, f: Scalar) -> Scalar:
        u = f / F_0
        polynomial = self.gain * f + self.square_n * u * jnp.abs(u) + self.cube_n * u**3 + self.offset_n
        return polynomial + self.beyond * jnp.maximum(f - self.level_n, 0.0)

import equinox as eqx
import jax.numpy as jnp

from acf_jax.effects import AbstractEffect, Motion, shape, strength
from acf_jax.effects._interface import Scalar, States
from acf_jax.effects.pad_mass import PadMass
from acf_jax.inference.free_curves._common import beginning, continued, passing

F_0, V_0 = 100.0, 0.1  # N, m/s: an impact's typical force and rate of compression
WIDTH = 50.0  # N, within which a step of the contact's law happens
LAST = (0.2,)  # share of the tried range whose slope goes on beyond it
STEEPEST = 5.0  # N in addition for each newton of the linear contact beyond the reach
LEVELS = (0.15, 0.3, 0.45, 0.6, 0.8)  # shares of the largest force where fits look for a kink
STARTS = (
    {"square_n": 1.0, "step_100_n": 1.0, "rate_n": 1.0},
    *({"beyond": 1.0, "level_n": share} for share in LEVELS),
    *({"beyond": 8.0, "level_n": share} for share in LEVELS[2:]),
    *({"flow_per_s": 100.0, "level_n": share} for share in (0.35, 0.7)),
    {"passing": 0.2, "frequency_hz": 30.0, "damping_ratio": 1.5},
    {"passing": 0.2, "frequency_hz": 200.0, "damping_ratio": 0.1},
    *({"pad_kg": 0.2, "frequency_hz": hz, "damping_ratio": 0.05} for hz in (150.0, 400.0)),
)
_from = beginning(STARTS)
PASSED = ("passing", "passing_rate_s", "pad_kg")  # what goes through dynamics


class UnknownContact(AbstractEffect):
    """A contact force as a free function of the linear contact's force and of the rate of compression.

    F = u + g(u) - g(u_0) with u = k_C s + u_0 and u_0 the force at first contact; g has polynomials, steps and a kink.
    Terms of the rate come in addition, what second-order dynamics make of k_C s, as a pad that relaxes, a pad that
    flows beyond a level, and one of its own mass. Above the reach g goes on straight, not falling faster than u grows:
    a polynomial beyond the forces that it was fitted to says nothing.
    """

    component = "contact"
    title = "Unknown cause at the contact"
    n_state = 5

    square_n: Scalar = strength(
        "N", -5e3, 5e3, _from("square_n"), 10.0, "at 100 N, with the square of the force"
    )
    cube_n: Scalar = strength("N", -5e3, 5e3, (0.0,), 5.0, "at 100 N, with the cube of the force")
    step_100_n: Scalar = strength("N", -5e3, 5e3, _from("step_100_n"), 10.0, "half a step at 100 N")
    step_175_n: Scalar = strength("N", -5e3, 5e3, (0.0,), 10.0, "half a step at 175 N")
    step_250_n: Scalar = strength("N", -5e3, 5e3, (0.0,), 10.0, "half a step at 250 N")
    rate_n: Scalar = strength("N", -5e3, 5e3, _from("rate_n"), 10.0, "at 0.1 m/s, with the rate")
    rate_2_n: Scalar = strength("N", -5e3, 5e3, (0.0,), 10.0, "at 0.1 m/s, with the square of the rate")
    dry_n: Scalar = strength("N", -500.0, 500.0, (0.0,), 5.0, "with the sign of the rate, at 100 N")
    product_n: Scalar = strength("N", -5e3, 5e3, (0.0,), 5.0, "at 100 N and 0.1 m/s, with rate times force")
    beyond: Scalar = strength(
        "1", -1.0, 60.0, _from("beyond"), 1.0, "in proportion to the force beyond a level"
    )
    passing: Scalar = strength("1", -8.0, 8.0, _from("passing"), 0.3, "share that passes through dynamics")
    passing_rate_s: Scalar = strength("s", -1e-1, 1e-1, (0.0,), 1e-3, "with the rate of what passed")
    flow_per_s: Scalar = strength(
        "1/s", 0.0, 5e3, _from("flow_per_s"), 100.0, "rate of flow, of the force beyond a level"
    )
    pad_kg: Scalar = strength("kg", 0.0, 3.0, _from("pad_kg"), 0.3, "mass of the pad")

    level_n: Scalar = shape(
        "N", 10.0, 5e3, _from("level_n", 0.7), "that level", of="force", needs=("beyond", "flow_per_s")
    )
    hardening: Scalar = shape(
        "1",
        0.01,
        10.0,
        (0.3,),
        "by which share of the force that has flown the level grows",
        needs=("flow_per_s",),
    )
    frequency_hz: Scalar = shape(
        "Hz", 5.0, 1500.0, _from("frequency_hz", 100.0), "natural frequency of dynamics and pad", needs=PASSED
    )
    damping_ratio: Scalar = shape(
        "1", 0.01, 5.0, _from("damping_ratio", 1.0), "their damping ratio", needs=PASSED
    )

    reach: Scalar = eqx.field(converter=jnp.asarray, default=jnp.inf)  # N, largest u that was tried

    def contact_force(self, motion: Motion, state: States) -> Scalar:
        v = motion.s_dot / V_0
        u_0 = motion.f_0
        linear = motion.rig.k_c * motion.s
        elastic = continued(self._elastic, linear + u_0, self.reach, LAST, STEEPEST) - self._elastic(u_0)
        size = jnp.maximum(linear + u_0, 0.0) / F_0
        viscous = self.rate_n * v + self.rate_2_n * v * jnp.abs(v) + self.product_n * v * size
        dry = self.dry_n * jnp.tanh(v / 0.05) * jnp.minimum(size, 1.0)
        passed, passed_rate, *_, flown = state
        past = self.passing * (passed - linear) + self.passing_rate_s * passed_rate - flown
        return elastic + viscous + dry + past

    def pad_displacement(self, state: States) -> tuple[Scalar, Scalar]:
        return self._pad.pad_displacement(state[2:4])

    def force_on_mass(self, motion: Motion, state: States) -> Scalar:
        return self._pad.force_on_mass(motion, state[2:4])

    def rates(self, motion: Motion, x_ddot: Scalar, state: States) -> States:
        linear, flown = motion.rig.k_c * motion.s, state[4]
        passed = passing(linear, state[0], state[1], self.frequency_hz, self.damping_ratio)
        flowing = linear + motion.f_0 - (1 + self.hardening) * flown - self.level_n
        flow = self.flow_per_s * jnp.maximum(flowing, 0.0)
        return (*passed, *self._pad.rates(motion, x_ddot, state[2:4]), flow)

    @property
    def _pad(self) -> PadMass:
        return PadMass(self.pad_kg, self.frequency_hz, self.damping_ratio)

    def _elastic(self, u: Scalar) -> Scalar:
        polynomial = self.square_n * u * jnp.abs(u) / F_0**2 + self.cube_n * (u / F_0) ** 3
        kink = self.beyond * jnp.maximum(u - self.level_n, 0.0)
        steps = ((100.0, self.step_100_n), (175.0, self.step_175_n), (250.0, self.step_250_n))
        return polynomial + kink + sum(size * jnp.tanh((u - centre) / WIDTH) for centre, size in steps)

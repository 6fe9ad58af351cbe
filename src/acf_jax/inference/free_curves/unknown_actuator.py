import jax.numpy as jnp

from acf_jax.effects import AbstractEffect, Motion, shape, strength
from acf_jax.effects._interface import Scalar, States
from acf_jax.effects.end_stop import EndStop
from acf_jax.inference.free_curves._common import beginning
from acf_jax.model import Impact

X_0, V_0 = 1e-3, 0.1  # m, m/s: an impact's typical stroke and speed
STARTS = (
    {"constant_n": 1.0, "pretension_share": 0.02, "stroke_2_n": 1.0, "dry_n": 1.0},
    {"held_share": 0.5},
    *({"beyond_n": -5.0, "level_m": level} for level in (0.25, 0.5, 1.0)),
    *({"constant_n": -10.0, "near_n": 10.0, "near_m": near} for near in (0.05, 0.3)),
)
_from = beginning(STARTS)


class UnknownActuator(AbstractEffect):
    """A force on the flange mass as a free function of its motion and of time.

    Polynomials of the stroke with a kink, dry friction, forces that come with time, and a flange that is held, as by a
    stop or by stiction, until the contact force exceeds the pretension.
    """

    component = "actuator"
    title = "Unknown cause at the actuator"

    constant_n: Scalar = strength("N", -300.0, 300.0, _from("constant_n"), 10.0, "constant")
    pretension_share: Scalar = strength(
        "1", -2.0, 2.0, _from("pretension_share"), 0.15, "in proportion to the pretension"
    )
    stroke_2_n: Scalar = strength(
        "N", -2e3, 2e3, _from("stroke_2_n"), 15.0, "at 1 mm, with the square of the stroke"
    )
    stroke_3_n: Scalar = strength("N", -2e3, 2e3, (0.0,), 15.0, "at 1 mm, with the cube of the stroke")
    near_n: Scalar = strength("N", -500.0, 500.0, _from("near_n"), 10.0, "within a short stroke")
    dry_n: Scalar = strength("N", -300.0, 300.0, _from("dry_n"), 10.0, "with the sign of the speed")
    speed_2_n: Scalar = strength("N", -2e3, 2e3, (0.0,), 10.0, "at 0.1 m/s, with the square of the speed")
    growing_n: Scalar = strength("N", -2e3, 2e3, (0.0,), 10.0, "that comes with time")
    regulation_share: Scalar = strength("1", -5.0, 5.0, (0.0,), 0.15, "share of the pretension, with time")
    held_share: Scalar = strength(
        "1", 0.0, 1.0, _from("held_share"), 0.5, "share of the pretension that holds the flange"
    )
    beyond_n: Scalar = strength("N", -2e3, 2e3, _from("beyond_n"), 15.0, "for each millimetre beyond a level")
    level_m: Scalar = shape(
        "m", 5e-5, 2e-2, _from("level_m", 0.5), "that level", of="stroke", needs=("beyond_n",)
    )
    near_m: Scalar = shape(
        "m", 1e-5, 5e-3, _from("near_m", 0.15), "within which a force appears", of="stroke", needs=("near_n",)
    )
    time_s: Scalar = shape(
        "s",
        5e-4,
        0.1,
        (1e-2,),
        "time constant of what comes with time",
        needs=("growing_n", "regulation_share"),
    )

    def initial_relief(self, impact: Impact) -> Scalar:
        return self._stop.initial_relief(impact)

    def release_force(self, impact: Impact) -> Scalar:
        return self._stop.release_force(impact)

    @property
    def _stop(self) -> EndStop:
        return EndStop(self.held_share)

    def force_on_mass(self, motion: Motion, state: States) -> Scalar:
        x, v = motion.x / X_0, motion.x_dot / V_0
        f_p = motion.impact.f_p
        of_stroke = (
            self.stroke_2_n * x * jnp.abs(x)
            + self.stroke_3_n * x**3
            + self.near_n * jnp.tanh(motion.x / self.near_m)
        )
        of_speed = -self.dry_n * jnp.tanh(v / 0.02) - self.speed_2_n * v * jnp.abs(v)
        of_kink = self.beyond_n * jnp.maximum(x - self.level_m / X_0, 0.0)
        of_time = (self.growing_n + self.regulation_share * f_p) * (1 - jnp.exp(-motion.t / self.time_s))
        return self.constant_n + self.pretension_share * f_p + of_stroke + of_kink + of_speed + of_time

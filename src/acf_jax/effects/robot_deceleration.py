import jax.numpy as jnp

from acf_jax.effects._interface import AbstractEffect, Scalar, States, shape, strength
from acf_jax.model import Impact, Rig


class RobotDeceleration(AbstractEffect):
    """The robot brakes during the impact, with the deceleration a + b v after the time t_0, until it stands still.

    t_0 r''' + r'' = -(a + b v_E) for t_0 < t < t_0 + v_E/(a + b v_E), and 0 before and after: what reacts late builds
    up slowly. A guarded stop: constant deceleration (a), or one that takes every speed to rest in the same time 1/b
    (ISO 10218-1:2011, protective stop). The paper assumes r = 0.
    """

    component = "robot"
    title = "Braking robot"
    remedy = "keep the robot's speed constant until after contact: end the path inside the part"

    deceleration_m_per_s2: Scalar = strength("m/s^2", 0.0, 200.0, (1.0, 5.0), 5.0, "deceleration a")
    rate_per_s: Scalar = strength(
        "1/s", 0.0, 1000.0, (5.0, 50.0), 30.0, "deceleration b in proportion to speed"
    )
    delay_s: Scalar = shape(
        "s", 1e-4, 0.03, (5e-4, 3e-3), "time t_0 from contact to braking, and in which that builds up"
    )

    def robot_displacement(self, rig: Rig, impact: Impact, t: Scalar, state: States) -> tuple[Scalar, Scalar]:
        deceleration = self.deceleration_m_per_s2 + self.rate_per_s * impact.v_e
        to_rest = impact.v_e / jnp.maximum(deceleration, 1e-6)
        begun, ended = self._since(t - self.delay_s), self._since(t - self.delay_s - to_rest)
        return -deceleration * (begun[0] - ended[0]), -deceleration * (begun[1] - ended[1])

    def _since(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """Displacement and velocity at t of an acceleration that builds up to 1 from 0 on."""
        since, tau = jnp.maximum(t, 0.0), self.delay_s
        velocity = since + tau * jnp.expm1(-since / tau)
        return 0.5 * since**2 - tau * velocity, velocity

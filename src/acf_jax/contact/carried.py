"""What a flange presses with that goes along with the robot, or rests once both have stopped."""

from collections.abc import Sequence

import jax.numpy as jnp
from jaxtyping import Array, Float

from acf_jax.effects import AbstractEffect, Motion
from acf_jax.model import Impact, Rig
from acf_jax.simulator.simulate import at_rest, make_system

Scalar = Float[Array, ""]
LATE = 100.0  # s, when all that comes with time is there: the slowest time constant of an effect is 3 s


def carried_force(
    rig: Rig, impact: Impact, effects: Sequence[AbstractEffect], x: Scalar | float, v: Scalar | float
) -> Scalar:
    """The contact force of a flange that is compressed by x and goes on with v, in equilibrium, N.

        F_0 + k_F x + d v + sum of max(-F_e - R_e, 0)

    Eq. (1) knows F_P as the contact's preload only; the actuator presses with it as long as the contact lasts. F_0 is
    the pretension as it acts, F_e an effect's force on the mass, at first contact or late, whichever presses more, and
    R_e by how much it relieves the contact beforehand. What would take from the force does not count. Nor does what an
    effect integrates for itself: the force control builds up F_P, which is there already.

    **Arguments:** `rig`, `impact`: one sample, F_P as commanded. `x`: m. `v`: m/s, zero at rest.
    """
    system = make_system(rig, impact, effects)
    f_p, rest = system.impact.f_p, at_rest(system.effects)
    x, v, zero = jnp.asarray(x, float), jnp.asarray(v, float), jnp.zeros(())
    first = Motion(rig, system.impact, system.label, zero, x, v, zero, zero, f_p, f_p)
    force = f_p + jnp.where(rig.k_f > 0, rig.k_f * x, 0.0) + rig.d * v
    for effect, state in zip(system.effects, rest.states, strict=True):
        pushes = [effect.force_on_mass(first._replace(t=jnp.asarray(t)), state) for t in (0.0, LATE)]
        relief = effect.initial_relief(system.impact)
        force += jnp.maximum(-jnp.minimum(*pushes) - relief, 0.0)
    return force

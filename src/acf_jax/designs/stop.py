"""By when, and within what travel, the robot stops or has to, so that a design's force holds its limit."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from acf_jax.contact.body import WALL
from acf_jax.contact.ended import Ended, ended
from acf_jax.contact.ending import Ending
from acf_jax.contact.model import ContactModel, spread
from acf_jax.contact.stop import Stop, latest_stop, stop_of
from acf_jax.designs.task import Task
from acf_jax.kept import compiled_quickly

# Of the limit. A design touches it by the simulation of a first peak, the stop is asked of another, with steps and
# alternatives of its own: their spreads differ by some percent. No sensor tells forces so close apart.
ROUNDING = 1e-3


def needed_stop(task: Task, z: np.ndarray, factor: float) -> Stop | None:
    """The stop that a design assumes: the stated one, or else the latest after which F + factor sigma holds the limit.

    Infinite where nothing passes the limit within a second, None where no stop is soon enough.
    """
    law, v_e = task.model.main.peak, float(z[-2])
    if isinstance(law, Ended):
        return stop_of(Ending(*map(float, law.ending)), v_e)

    def keeps(time: float) -> bool:
        ending = Ending(*map(jnp.asarray, Ending(stop_after=time)))
        upper, exists = _upper_until(task.model, jnp.asarray(z), ending, jnp.asarray(factor))
        return bool(exists) and float(upper) <= task.limit * (1 + ROUNDING)

    time = latest_stop(keeps)
    return None if time is None else Stop(time, time * v_e)


@compiled_quickly
def _upper_until(
    model: ContactModel, z: Float[Array, " p"], ending: Ending, factor: Float[Array, ""]
) -> tuple[Array, Array]:
    """F + factor sigma until the ending, and whether it can be followed so far."""
    peak, own = spread(ended(model, ending), z, WALL, factor)
    return peak.force + factor * own.std, peak.exists

"""By when, and within what travel, the robot stops or has to, so that a design's force holds its limit."""

import jax.numpy as jnp
import numpy as np

from acf_jax.contact.body import WALL
from acf_jax.contact.ended import Ended, ended
from acf_jax.contact.ending import Ending
from acf_jax.contact.model import spread
from acf_jax.contact.stop import Stop, latest_stop, stop_of
from acf_jax.designs.task import Task

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
        peak, own = spread(ended(task.model, ending), jnp.asarray(z), WALL, jnp.asarray(factor))
        return bool(peak.exists) and float(peak.force + factor * own.std) <= task.limit * (1 + ROUNDING)

    time = latest_stop(keeps)
    return None if time is None else Stop(time, time * v_e)

"""By when, and within what travel, the robot stops or has to, so that a design's force holds its limit."""

import jax.numpy as jnp
import numpy as np

from acf_jax.contact.body import WALL
from acf_jax.contact.ended import Ended, ended
from acf_jax.contact.ending import Ending
from acf_jax.contact.model import spread
from acf_jax.contact.stop import Stop, latest_stop, stop_of
from acf_jax.designs.task import Task

# a design touches the limit as one simulation has it, and is asked about by another, with steps of its own
ROUNDING = 1e-4  # of the limit: more than their forces differ by
OF_SPREAD = 0.05  # of a standard deviation: more than theirs do where a law has a kink


def needed_stop(task: Task, z: np.ndarray, factor: float) -> Stop | None:
    """The stop that a design assumes: the stated one, or else the latest after which F + factor sigma holds the limit.

    Infinite where nothing passes the limit within a second, None where no stop is soon enough.
    """
    law, v_e = task.model.main.peak, float(z[-2])
    if isinstance(law, Ended):
        return stop_of(Ending(*map(float, law.ending)), v_e)

    _, first = spread(task.model, jnp.asarray(z), WALL, jnp.asarray(factor))
    highest = task.limit * (1 + ROUNDING) + OF_SPREAD * abs(factor) * float(first.std)

    def keeps(time: float) -> bool:
        ending = Ending(*map(jnp.asarray, Ending(stop_after=time)))
        peak, own = spread(ended(task.model, ending), jnp.asarray(z), WALL, jnp.asarray(factor))
        return bool(peak.exists) and float(peak.force + factor * own.std) <= highest

    time = latest_stop(keeps)
    return None if time is None else Stop(time, time * v_e)

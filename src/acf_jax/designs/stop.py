"""By when, and within what travel, the robot stops or has to, so that a design's force holds its limit."""

import math

import jax.numpy as jnp
import numpy as np

from acf_jax.contact.body import WALL
from acf_jax.contact.ended import Above, Ended, ended
from acf_jax.contact.ending import Ending
from acf_jax.contact.model import draw_sample, sample_forces
from acf_jax.contact.stop import Stop, latest_stop, stop_of
from acf_jax.designs.chance import held_share
from acf_jax.designs.task import Task

# Standard errors of the drawn probability that are left once later forces have broken the limit in some of the draws:
# half of what the first peak leaves.
TO_SPARE = 1.0
# Of the limit, by which a later force may pass it. A draw's first peak is found by a simulation with steps of its own,
# which understates it by a thousandth at most, and among the draws of a design many touch the limit.
ROUNDING = 1e-3
OF_DOUBLES = 1e-9  # of the limit, which a first peak may pass
GLANCE = 4  # times as many draws as may still break the limit: enough to see that far more do


def needed_stop(task: Task, z: np.ndarray, draws: int, seed: int) -> Stop | None:
    """The stop that a design assumes: the stated one, or else the latest with which the stated probability holds.

    Among the draws that the design was made with, those hold the limit whose first peak does and whose every later
    force, until robot and flange are at rest, does too. The stop is the latest for which their share is enough. A draw
    that breaks the limit with one stop counts as broken with every later one.

    Infinite where the limit holds for a second, None where no stop is soon enough.
    """
    model, v_e = task.model, float(z[-2])
    if isinstance(model.main.peak, Ended):
        return stop_of(Ending(*map(float, model.main.peak.ending)), v_e)
    draws = 1 if model.is_certain else draws
    sample = draw_sample(model, z, draws, seed)
    force, exists = sample_forces(model, sample, WALL)
    open_ = exists & (force <= task.limit * (1 + OF_DOUBLES))  # whether they hold depends on the stop
    share = min(held_share(task.probability, draws, TO_SPARE), 1.0)
    left = int(open_.sum()) - math.ceil(share * draws)  # that may yet break it
    if left < 0:
        return None

    def broken(time: float, asked: np.ndarray) -> np.ndarray:
        ending = Ending(*map(jnp.asarray, Ending(stop_after=time)))
        found = asked.copy()
        for law in (Above, Ended):  # what its energy cannot break need not be simulated
            force, exists = sample_forces(ended(model, ending, law), sample.part(found), WALL)
            found[found] = ~exists | (force > task.limit * (1 + ROUNDING))
        return found

    def keeps(time: float) -> bool:
        nonlocal open_, left
        every = np.flatnonzero(open_)
        some = np.zeros(draws, bool)
        some[every[:: max(1, every.size // (GLANCE * (left + 1)))]] = True
        if broken(time, some).sum() > left:
            return False
        lost = broken(time, open_)
        if lost.sum() > left:
            open_ = lost  # the others hold with every earlier stop
            return False
        open_, left = open_ & ~lost, left - int(lost.sum())
        return True

    time = latest_stop(keeps)
    return None if time is None else Stop(time, time * v_e)

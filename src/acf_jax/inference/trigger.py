"""How far triggers scatter about their common time, told by repeats of a condition alone: no model is needed."""

import numpy as np

from acf_jax.inference.observations import TRIGGER, Observations
from acf_jax.inference.repeats import alike

SIZES = np.geomspace(0.02, TRIGGER, 33)  # that are tried, in sampling intervals
ALLOWED = 2.0  # log likelihood by which the size taken is worse than the best: twice its standard deviation
UNLIKE = (
    4.0  # mean square of what no trigger explains, over the noise's: such repeats tell nothing of triggers
)


def trigger_scatter(observations: Observations) -> float:
    """Standard deviation of trigger times, in sampling intervals: the largest that the repeats allow.

    Differences between repeats hold noise, rings, and what the scatter of trigger, velocity and pretension makes of the
    condition's mean trace. Their likelihood is computed for each of `SIZES`; without repeats every size is as good, and
    the largest one stands.
    """
    total = np.zeros(len(SIZES))
    for one in (trials.beside(observations.noise) for trials in alike(observations)):
        spreads = [one.spread(size, observations.rings) for size in SIZES]
        if one.left(spreads[-1]) < UNLIKE:  # the largest explains most
            total += [one.log_likelihood(spread) for spread in spreads]
    return float(SIZES[total >= total.max() - ALLOWED].max())

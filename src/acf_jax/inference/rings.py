"""Which rings the trials of one condition do not share, told by repeats alone: no model is needed."""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
from scipy.optimize import minimize

from acf_jax.inference.observations import TRIGGER, Observations
from acf_jax.inference.repeats import Alike, Repeats
from acf_jax.inference.ring import Ring

MOST = 3  # of rings: each costs two nuisances a trial
FREQUENCIES = 90  # that are tried: the refinement finds a maximum from 5 % beside it
DECAYS = (0.15, 0.4, 1.2)  # that are tried, of the longest trial: the refinement goes on from there
LOWEST, HIGHEST = 0.5, 0.48  # frequencies, over the longest trial and of the sampling rate
SIZES = np.geomspace(2e-3, 0.3, 12)  # of the typical force, that are tried
POWERS = (0, 1)
REFINED = (0.1, 1.5, 1.5)  # logarithm by which frequency, decay and size may differ from those tried
ODDS = 20.0  # of a ring to none from which on it counts


def find_rings(observations: Observations, trials: Sequence[Alike]) -> tuple[Ring, ...]:
    """Rings whose size and phase differ between repeats, the clearest first; none where there are no repeats.

    **Arguments:** `trials`: repeats, best as a fit leaves them (`alike`). By the mean trace alone a mass that rings
    faster than the samples tell, in step with the trigger, looks like a ring of its own.

    The differences between repeats hold noise, and what the scatter of velocity, pretension and trigger makes of the
    trace. A ring is found where one more makes them so much more probable that the number of shapes that were tried
    does not explain it. The condition that gains most does not count: what it alone shows is a fault.
    """
    of_conditions = [one.beside(observations.noise) for one in trials]
    if len(of_conditions) < 2:
        return ()
    worth = np.log(ODDS * FREQUENCIES * len(DECAYS) * len(POWERS))
    found: list[Ring] = []
    while len(found) < MOST:
        best, gain = _best(observations, of_conditions, found)
        if gain < worth:
            break
        found.append(best)
    return tuple(found)


def _best(
    observations: Observations, of_conditions: Sequence[Repeats], found: Sequence[Ring]
) -> tuple[Ring, float]:
    """The ring that gains most beside those found, and the log likelihood that it gains in all conditions but one."""
    typical = float(np.median([r.largest for r in of_conditions]))
    spreads = [r.spread(TRIGGER, found) for r in of_conditions]
    before = [r.log_likelihood(s) for r, s in zip(of_conditions, spreads, strict=True)]
    shapes = list(_shapes(observations, typical))

    def gains(r: Repeats, spread: np.ndarray) -> np.ndarray:
        columns = np.stack([s.columns(r.time[None], np.array([r.largest]))[0] for s in shapes])
        return r.gains(columns, typical * SIZES, spread)

    gained = np.sum(list(map(gains, of_conditions, spreads)), axis=0)
    k, i = np.unravel_index(int(gained.argmax()), gained.shape)
    begin = shapes[k]

    def ring(x: np.ndarray) -> Ring:
        frequency, decay, size = np.exp(x) * (begin.frequency, begin.decay, typical * SIZES[i])
        return begin._replace(frequency=float(frequency), decay=float(decay), size=float(size))

    def gains_of(one: Ring) -> np.ndarray:
        pairs = zip(of_conditions, spreads, strict=True)
        return np.array([r.log_likelihood(np.concatenate([s, r.seen([one])])) for r, s in pairs]) - before

    options = {"xatol": 1e-2, "fatol": 1e-2}
    bounds = [(-x, x) for x in REFINED]
    end = minimize(
        lambda x: -gains_of(ring(x)).sum(), np.zeros(3), method="Nelder-Mead", bounds=bounds, options=options
    )
    best = ring(end.x)
    gained_by = gains_of(best)
    return best, float(gained_by.sum() - gained_by.max())


def _shapes(observations: Observations, typical: float) -> Iterator[Ring]:
    """Every ring that is tried, with a size of 1 N."""
    longest, interval = float(observations.time[observations.used].max()), float(observations.spacings.min())
    frequencies = np.geomspace(LOWEST / longest, HIGHEST / interval, FREQUENCIES)
    for power, decay, frequency in product(POWERS, DECAYS, frequencies):
        yield Ring(float(frequency), decay * longest, 1.0, typical, power)

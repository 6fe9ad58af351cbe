"""What repeats say of all that differs from trial to trial: rings, triggers, and what neither explains."""

from dataclasses import replace

import numpy as np

from acf_jax.dataset import Noise
from acf_jax.inference.noise_colour import most_probable
from acf_jax.inference.observations import TRIGGER, Observations
from acf_jax.inference.repeats import repeats
from acf_jax.inference.rings import find_rings
from acf_jax.inference.trigger import UNLIKE, spread_of, trigger_scatter

SETTLED = 1.02  # mean square of what is left over the noise's, at which its size is known well enough


def with_scatter(observations: Observations) -> Observations:
    """The same observations, with the rings and the scatter of the triggers that their own repeats show.

    What a quiet sensor reads before contact is the least that the noise can be. Where the repeats of most conditions
    still differ by far more, they say how well any model of the conditions can do (pure error; Draper and Smith,
    'Applied Regression Analysis', 1998, ch. 2), and the noise is taken as large as that, and of its colour.
    """
    loose = replace(observations, trigger_std=TRIGGER, rings=())
    ringing = replace(loose, rings=find_rings(loose))
    scattered = replace(ringing, trigger_std=trigger_scatter(ringing))
    ratio = _pure_error(scattered)
    if ratio < UNLIKE:
        return scattered
    noise = replace(_colour(scattered), source="repeats")
    scattered = replace(scattered, noise=noise)
    while (ratio := _pure_error(scattered)) > SETTLED:  # beside more noise rings and triggers explain less
        noise = replace(noise, std=float(noise.std * np.sqrt(ratio)))
        scattered = replace(scattered, noise=noise)
    return scattered


def _colour(observations: Observations) -> Noise:
    """The noise whose colour makes most probable what repeats differ by, as large as this is at each condition."""
    o = observations

    def loss(noise: Noise) -> float:
        beside = replace(o, noise=noise)
        found = repeats(beside)
        left = [one.left(spread_of(one, beside, o.trigger_std)) for one in found]
        size = sum(0.5 * one.differences.size * np.log(x) for one, x in zip(found, left, strict=True))
        return float(size + sum(len(one.differences) * one.whiten.log_volume for one in found))

    return most_probable(o.noise, float(np.median(o.spacings)), loss)


def _pure_error(observations: Observations) -> float:
    """Mean square of what no ring, trigger, velocity or pretension explains of repeats, over the noise's; 1 without.

    The median over the conditions: one faulty trial makes one condition scatter.
    """
    o = observations
    found = [one.left(spread_of(one, o, o.trigger_std)) for one in repeats(o)]
    return float(np.median(found)) if found else 1.0

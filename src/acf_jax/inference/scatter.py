"""What repeats say of all that differs from trial to trial: rings, triggers, and what neither explains."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from acf_jax.dataset import Noise
from acf_jax.inference.fit import Fit
from acf_jax.inference.noise_colour import most_probable
from acf_jax.inference.observations import TRIGGER, Observations
from acf_jax.inference.repeats import Alike, Repeats, alike
from acf_jax.inference.rings import find_rings
from acf_jax.inference.trigger import UNLIKE, trigger_scatter

SETTLED = 1.02  # mean square of what is left over the noise's, at which its size is known well enough


def with_scatter(observations: Observations, fitted: Fit | None = None) -> Observations:
    """The same observations, with the scatter of the triggers that their own repeats show, and beside a fit with more.

    **Arguments:** `fitted`: the best explanation. What repeats differ by beside it, each with the velocity, pretension
    and trigger that it finds, are rings. Where the repeats of most conditions still differ by far more than a quiet
    sensor reads before contact, they say how well any model of the conditions can do (pure error; Draper and Smith,
    'Applied Regression Analysis', 1998, ch. 2), and the noise is taken as large as that, and of its colour.
    """
    loose = replace(observations, trigger_std=TRIGGER, rings=())
    if fitted is None:
        return replace(loose, trigger_std=trigger_scatter(loose))
    trials = alike(loose, fitted)
    ringing = replace(loose, rings=find_rings(loose, trials))
    scattered = replace(ringing, trigger_std=trigger_scatter(ringing))
    if _pure_error(scattered, trials, scattered.noise) < UNLIKE:
        return scattered
    noise = replace(_colour(scattered, trials), source="repeats")
    while (ratio := _pure_error(scattered, trials, noise)) > SETTLED:  # beside more noise rings explain less
        noise = replace(noise, std=float(noise.std * np.sqrt(ratio)))
    return replace(scattered, noise=noise)


def _left(o: Observations, trials: Sequence[Alike], noise: Noise) -> tuple[list[Repeats], list[float]]:
    """Repeats beside some noise, and the chi-square of a sample that no ring, trigger, velocity or pretension takes."""
    found = [one.beside(noise) for one in trials]
    return found, [one.left(one.spread(o.trigger_std, o.rings)) for one in found]


def _colour(o: Observations, trials: Sequence[Alike]) -> Noise:
    """The noise whose colour makes most probable what repeats differ by, as large as this is at each condition."""

    def loss(noise: Noise) -> float:
        found, left = _left(o, trials, noise)
        size = sum(0.5 * one.differences.size * np.log(x) for one, x in zip(found, left, strict=True))
        return float(size + sum(len(one.differences) * one.whiten.log_volume for one in found))

    return most_probable(o.noise, float(np.median(o.spacings)), loss)


def _pure_error(o: Observations, trials: Sequence[Alike], noise: Noise) -> float:
    """Mean square of what no ring, trigger, velocity or pretension explains of repeats, over the noise's; 1 without.

    The median over the conditions: one faulty trial makes one condition scatter.
    """
    _, left = _left(o, trials, noise)
    return float(np.median(left)) if left else 1.0

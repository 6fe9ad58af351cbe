"""The next trial: where two explanations that still stand predict the most different forces."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import norm

from acf_jax.inference.fit import Fit
from acf_jax.inference.forward import reach_of
from acf_jax.inference.linear import linearise
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import Explanation

REPEATS = 3  # of a proposed trial: from three on their scatter shows, too
STRETCH = 1.25  # how far beyond the tried range a trial may be proposed


@dataclass(frozen=True)
class Experiment:
    """A proposed trial and what it would bring."""

    v_e: float  # m/s
    f_p: float  # N
    repeats: int
    separates: tuple[Explanation, Explanation]
    error_before: float
    error_after: float


def error_probability(p: float, q: float, distance: float) -> float:
    """Probability that the more probable of two explanations is wrong after a signal at the whitened distance d.

    For Gaussian signals with prior probabilities p and q: p Q(d/2 + ln(p/q)/d) + q Q(d/2 - ln(p/q)/d), over p + q.
    """
    p, q = p / (p + q), q / (p + q)
    if distance < 1e-9 or min(p, q) == 0.0:
        return min(p, q)
    shift = (np.log(p) - np.log(q)) / distance
    return float(p * norm.sf(distance / 2 + shift) + q * norm.sf(distance / 2 - shift))


def propose(
    observations: Observations, first: tuple[Fit, float], second: tuple[Fit, float]
) -> Experiment | None:
    """The condition on a grid about the tried ones at which the two fits differ most, parameters allowed to adapt.

    The distance counts only what noise, trial-to-trial spread and the remaining uncertainty of both fits' parameters
    do not hide.
    """
    o = observations
    if o.peak_only.all():
        return None
    low, high = o.v_e.min() / STRETCH, o.v_e.max() * STRETCH
    pretensions = np.unique(np.concatenate([o.f_p, [o.f_p.min() / STRETCH, o.f_p.max() * STRETCH]]))
    conditions = [(v, f) for v in np.linspace(low, high, 7) for f in pretensions]
    longest = int(np.argmax(o.used.sum(1)))
    planned = o.subset(np.arange(len(o.names)) == longest)
    # elsewhere the range ends at other times, and a robot that is told another speed moves in another way
    still = planned.robot and planned.robot.steady()
    planned = replace(planned, used=planned.weighed, censored=None, robot=still)
    fits = (first[0], second[0])
    reaches = [reach_of(x.explanation, x.physical, o.v_e, o.f_p, x.grid) for x in fits]
    distances = [_distance(planned, v, f, fits, reaches) for v, f in conditions]
    pick = int(np.argmax(distances))
    after = error_probability(first[1], second[1], distances[pick])
    before = min(first[1], second[1]) / (first[1] + second[1])
    v, f = conditions[pick]
    names = (first[0].explanation, second[0].explanation)
    return Experiment(float(v), float(f), REPEATS, names, float(before), float(min(after, before)))


def _distance(
    planned: Observations, v: float, f: float, fits: Sequence[Fit], reaches: Sequence[float]
) -> float:
    """Whitened distance of two fits' predictions of a trial's repeats; 0 where one of them goes astray.

    Noise and nuisances of the repeats are their own, the fits' parameters are as uncertain in all of them.
    """
    trial = replace(planned, v_e=np.array([v]), f_p=np.array([f]))
    quiet = np.zeros((1, planned.n_nuisances))
    lines = [
        linearise(trial, x.explanation, x.coordinates, x.u, quiet, x.grid, reach)
        for x, reach in zip(fits, reaches, strict=True)
    ]
    if not all(line.is_sound for line in lines):
        return 0.0
    difference = np.sqrt(REPEATS) * (lines[0].residual - lines[1].residual)[0]
    columns = [lines[0].by_nuisance[0].T]
    for x, line in zip(fits, lines, strict=True):
        columns.append(np.sqrt(REPEATS) * line.by_parameter[0].T @ x.root)
    spread = np.concatenate(columns, axis=1)
    inner = np.linalg.solve(spread.T @ spread + np.eye(spread.shape[1]), spread.T @ difference)
    return float(np.sqrt(max(0.0, difference @ difference - (spread.T @ difference) @ inner)))

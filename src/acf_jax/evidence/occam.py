"""How much of all that an effect can do explains the data as well as its best fit: the price of its freedom.

A fit of an effect always finds something in noise, and the more it may choose from the more it finds. The odds of an
effect are therefore the likelihood averaged over its forms and sizes, not the largest one (MacKay, 'Information
Theory, Inference, and Learning Algorithms', 2003, ch. 28). Near the paper's model that average costs little: there an
effect adds its signature, in proportion to its size, and rig and trials answer to first order.
"""

from collections.abc import Sequence

import numpy as np
from scipy.stats import norm, qmc

from acf_jax.effects import library
from acf_jax.inference.fit import Fit, grid_for
from acf_jax.inference.forward import Grid, plain_forward
from acf_jax.inference.interpolation import combine, taps
from acf_jax.inference.linear import is_bounded
from acf_jax.inference.observations import N_NUISANCE, Observations
from acf_jax.inference.parameters import RIG, every_effect
from acf_jax.inference.projection import Projector, Reduced

LOG2_FORMS = 5  # of how many forms are drawn of each effect, beside that of its fit
WITHIN = 2.0  # prior standard deviations of a shape within which forms are drawn
SIZES = np.geomspace(2.0, 60.0, 12)  # whitened distances that an effect is as likely to have
FINE = np.linspace(0.0, 12.0, 61)  # those among which the largest likelihood is sought
SHOWN = 2.0  # whitened distance at which signatures are computed
NEAREST, FARTHEST = 0.3, 20.0  # of those that count: other forms do not get as large, or not as small
FIRST = 1e-2  # of its typical size: an effect from which that distance is extrapolated
LADDER = np.geomspace(
    1e-3, 3.0, 9
)  # typical sizes that are tried where the distance does not go with the size
NOTHING = 1e-9  # of a whitened distance: rounding


def volumes(observations: Observations, recalibrated: Fit, fits: Sequence[Fit]) -> dict[str, float]:
    """Log of the share of each effect's forms and sizes that explain the data as well as its best fit.

    **Arguments:** `recalibrated`: the fit of the paper's model, which leaves little: the shares are those near it.
    `fits`: one of each single effect that is asked for; others are passed over.

    **Returns:** the log shares by effect; none where a peak is all that a trial has.
    """
    if observations.peak_only.any():
        return {}
    near = _Near(observations, recalibrated)
    single = [f for f in fits if len(f.explanation) == 1 and f.explanation[0] in library()]
    shares = {f.explanation[0]: near.share(f) for f in single}
    return {name: share for name, share in shares.items() if share is not None}


class _Near:
    """The recalibrated model, and what effects add to its forces."""

    def __init__(self, observations: Observations, recalibrated: Fit):
        self.observations, self.rig = observations, recalibrated.theta[: len(RIG)]
        self.projector = Projector.of(recalibrated)
        shift = recalibrated.nuisance[:, :N_NUISANCE] * observations.nuisance_std
        self.times = observations.time - (shift[:, 2] + recalibrated.common[1])[:, None]
        # repeats differ so little that one simulation does for all of them
        _, self.member = np.unique(observations.condition, return_inverse=True)
        count = np.bincount(self.member)
        self.v_e = np.bincount(self.member, observations.v_e + shift[:, 0]) / count
        self.f_p = np.bincount(self.member, observations.f_p + shift[:, 1]) / count

    def share(self, fitted: Fit) -> float | None:
        """The log share of a single effect; None where none of its forms is shown."""
        reduced, distance = self._signatures(fitted.explanation[0], _forms(fitted))
        is_shown = (distance > NEAREST) & (distance < FARTHEST)
        if not is_shown.any():
            return None
        shown = reduced.of(is_shown)
        one = 1 / distance[is_shown, None]
        largest = self.projector.gains(shown, one * FINE).max()
        return float(np.log(np.exp(self.projector.gains(shown, one * SIZES) - largest).mean()))

    def _signatures(self, name: str, forms: np.ndarray) -> tuple[Reduced, np.ndarray]:
        """The signatures of an effect's forms (k, q), each at about the distance `SHOWN`, and their distances (k,)."""
        known = every_effect()[name].parameters()
        has_shape = any(p.shape for p in known)
        grid = grid_for(self.observations, (name,))
        without = self._forces((), np.empty((1, 0)), grid)

        def seen(scale: np.ndarray | float) -> tuple[Reduced, np.ndarray]:
            forces = self._forces((name,), _sized(name, forms, scale), grid) - without
            signals = self.observations.whiten(forces.swapaxes(0, 1)).swapaxes(0, 1)
            sound = np.array([is_bounded(signal) for signal in signals])
            reduced = self.projector.reduce(np.where(sound[:, None, None], signals, 0.0))
            return reduced, np.maximum(self.projector.distances(reduced), NOTHING)

        _, distance = seen(FIRST)
        reduced, distance = seen(FIRST * SHOWN / distance)
        is_off = (distance < NEAREST) | (distance > FARTHEST)
        if is_off.mean() < 0.5 or not has_shape:
            return reduced, distance
        off = np.abs(np.log([seen(size)[1] / SHOWN for size in LADDER]))
        return seen(LADDER[off.argmin(0)])

    def _forces(self, explanation: tuple[str, ...], forms: np.ndarray, grid: Grid) -> np.ndarray:
        """The sensed force of every trial, N, (k, trials, n), with each of `forms` (k, q)."""
        theta = np.column_stack([np.tile(self.rig, (len(forms), 1)), forms])
        forces = plain_forward(explanation, theta, self.v_e, self.f_p, grid)
        with np.errstate(over="ignore", invalid="ignore"):  # of an unstable integration
            result = []
            for sensed, contact in zip(*forces, strict=True):
                near, weight, _ = taps(self.times, grid.h, contact[self.member])
                result.append(combine(sensed[self.member, None], near, weight)[:, 0] * self.observations.used)
        return np.array(result)


def _forms(fitted: Fit) -> np.ndarray:
    """Parameters (k, q) of a single effect at typical sizes: drawn from its prior, and as they were fitted.

    Of several strengths each stands alone as often as all together; what may act either way does so.
    """
    (name,) = fitted.explanation
    known = every_effect()[name].parameters()
    strengths = [k for k, p in enumerate(known) if not p.shape]
    drawn = qmc.Sobol(len(known) + 1, rng=0).random_base2(LOG2_FORMS)
    part = (drawn[:, -1] * (len(strengths) + 1)).astype(int)  # which strength acts; the last one: all
    forms = np.empty((len(drawn), len(known)))
    for k, p in enumerate(known):
        if p.shape:
            tail = norm.cdf(-WITHIN)
            u = norm.ppf(tail + (1 - 2 * tail) * drawn[:, k])
            forms[:, k] = fitted.coordinates.centre[len(RIG) + k] * np.exp(
                fitted.coordinates.width[len(RIG) + k] * u
            )
        else:
            alone, together = part == strengths.index(k), part == len(strengths)
            forms[:, k] = p.scale * (alone + together * drawn[:, k])
    if len(known) == 1:
        forms = forms[:1]  # all alike
    if every_effect()[name].acts_either_way():
        other = forms.copy()
        other[:, strengths[0]] *= -1
        forms = np.concatenate([forms, other])
    found = fitted.physical[len(RIG) :]
    return np.concatenate([forms, found[None]]) if found[strengths].any() else forms


def _sized(name: str, forms: np.ndarray, scale: np.ndarray | float) -> np.ndarray:
    """Forms (k, q) with their strengths multiplied, all of them alike and so that each stays within its bounds."""
    known = every_effect()[name].parameters()
    strengths = np.array([not p.shape for p in known])
    low, high = np.array([[p.low for p in known], [p.high for p in known]])
    room = np.where(forms < 0, low, high) / np.where(forms == 0, np.finfo(float).tiny ** 0.5, forms)
    within = np.minimum(scale, room[:, strengths].min(1))
    return np.where(strengths, forms * within[:, None], forms)

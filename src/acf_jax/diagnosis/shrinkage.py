"""How far the gap shrinks on conditions that no fit saw, with an interval."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

from acf_jax.diagnosis.heldout import CrossValidation, HeldOut
from acf_jax.evidence.learnt import ELSEWHERE
from acf_jax.inference.fit import Fit
from acf_jax.inference.forward import forward
from acf_jax.inference.interpolation import phase_end
from acf_jax.inference.observations import TIMING, Observations

RESAMPLES = 2000  # of the bootstrap over conditions
DRAWS = 200  # of the parameters
WORLDS = 20_000  # draws of what may be true: the ends of an interval are known to a hundredth of its width
FORM = 0.01  # share of the gap's mean square that laws leave which are right, but not exact
ENDS = (0.025, 0.975)  # of a 95 % interval
MOST = 500.0  # logarithm of a ratio: of two conditions it may be any, and its square is still a number


@dataclass(frozen=True)
class Shrinkage:
    """1 - corrected/recalibrated with a 95 % interval."""

    value: float
    ci95: tuple[float, float]

    @classmethod
    def of(cls, left: np.ndarray) -> "Shrinkage":
        """Median and interval, of draws of what is left of the gap's mean square."""
        low, median, high = np.quantile(np.sqrt(left), (ENDS[0], 0.5, ENDS[1])).tolist()
        return cls(1 - median, (1 - high, 1 - low))


class Belief(NamedTuple):
    """What the posterior says of the corrected model."""

    right: float  # probability that its laws are the causes; 0 of a free curve, which is none
    discrepancy: Mapping[float, float]  # probability of each size of the discrepancy beside them


def held_out_left(
    validation: CrossValidation, corrected: Fit, belief: Belief, seed: int
) -> np.ndarray | None:
    """What a corrected model leaves of the gap of the recalibrated one, as of `left_elsewhere`."""
    if not validation.is_possible:
        return None
    fits = validation.recalibrated, corrected
    held = validation.of(validation.recalibrated), validation.of(corrected)
    return left_elsewhere(validation.observations, fits, held, belief, seed)


def left_elsewhere(
    observations: Observations,
    fits: tuple[Fit, Fit],
    held: tuple[HeldOut, HeldOut],
    belief: Belief,
    seed: int,
) -> np.ndarray | None:
    """What is left of the gap's mean square on other conditions, what no model can predict taken off both.

    **Arguments:** `fits`, `held`: of the recalibrated and of the corrected model.

    Worlds are drawn: parameters from their covariance, an error of form, a discrepancy, and how much of the delay that
    all triggers share is none of theirs. Where the laws are right the form is off by about `FORM` of the gap's mean
    square; where they are wrong, by anything from that to all of it. The conditions held out weigh these worlds: the
    mean square error there is known as well as a bootstrap over conditions says. Other conditions differ from those
    that were tried as these differ from one another, and by what laws leave that are not exact.

    **Returns:** (WORLDS,) draws of the ratio; None where the held-out conditions show no gap at all.
    """
    o, used = observations, observations.traced
    recalibrated, corrected = held
    wanted = (corrected.excess, recalibrated.excess, corrected.floor, used.astype(float))
    _, sums = _by_condition(o.condition, [np.where(used, values, 0.0).sum(1) for values in wanted])
    left, gap, floor, samples = sums.sum(0)
    if not samples or gap <= 0:
        return None
    resampled = sums[resample(len(sums), seed)].sum(1)
    left_there, gap_there, _, samples_there = resampled[resampled[:, 3] > 0].T
    noise = floor / samples
    unsure = max(float((left_there / samples_there).std()), noise * np.sqrt(2 / samples))

    random = np.random.default_rng(seed)
    error, late, of_gap = _drawn(_possible_errors(o, *fits, seed), random)
    is_right = random.random(WORLDS) < belief.right
    wrong = np.exp(random.uniform(np.log(FORM), 0.0, WORLDS))
    form = np.where(is_right, FORM * random.standard_normal(WORLDS) ** 2, wrong)
    sizes = random.choice(list(belief.discrepancy), WORLDS, p=list(belief.discrepancy.values()))
    many = sizes**2 * float((o.force[used] ** 2).mean())
    squared = error + form * of_gap + np.where(is_right, many, 0.0)
    log_weight = -0.5 * ((left / samples - squared) / unsure) ** 2
    weight = np.exp(log_weight - log_weight.max())
    kept = random.choice(WORLDS, WORLDS, p=weight / weight.sum())
    # each trial held out was shifted to where it fits best: it says nothing of a delay that is the rig's
    ratio = ((squared + late) / of_gap)[kept]
    before = (np.maximum(left, 0.0) / samples + noise) / (gap / samples + noise)
    there = np.maximum(left_there, 0.0) / samples_there + noise
    elsewhere = there / (np.maximum(gap_there, 0.0) / samples_there + noise) / before
    return np.asarray(ratio * _as_elsewhere(elsewhere, len(sums), random) * _forms_elsewhere(random))


def _drawn(parts: tuple[np.ndarray, ...], random: np.random.Generator) -> tuple[np.ndarray, ...]:
    """The same draws of each part."""
    chosen = random.integers(DRAWS, size=WORLDS)
    return tuple(part[chosen] for part in parts)


def _as_elsewhere(bootstrapped: np.ndarray, conditions: int, random: np.random.Generator) -> np.ndarray:
    """(WORLDS,) by what factor a ratio of mean squares differs on other conditions, as many as were tried.

    Both the tried ones and the others are a sample of all: two draws of the bootstrap. Their spread is told from n
    conditions, so that it has the tails of a Student's t with n - 1 degrees of freedom.
    """
    factor = np.log(np.maximum(bootstrapped, np.finfo(float).tiny))
    two = random.choice(factor, (2, WORLDS)).sum(0)
    freedom = max(conditions - 1, 1)
    log_ratio = two * np.sqrt(conditions / random.chisquare(freedom, WORLDS))
    return np.asarray(np.exp(np.minimum(log_ratio, MOST)))


def _forms_elsewhere(random: np.random.Generator) -> np.ndarray:
    """(WORLDS,) by what factor a mean square differs on other conditions: what is left has few directions.

    Along each it is a normal draw, whose square may well be next to nothing, but not many times as large.
    """
    directions = ELSEWHERE
    return random.chisquare(directions, WORLDS) / float(chi2.median(directions))


def _possible_errors(
    observations: Observations, recalibrated: Fit, corrected: Fit, seed: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(DRAWS,) mean squares over the tried conditions, N^2, were a draw of the parameters the truth, to first order.

    Of the corrected model's error, of what comes to it by a delay that is the rig's, and of the recalibrated model's
    error; at times after contact as far apart as samples.
    """
    o = observations
    traced = np.flatnonzero(o.traced.any(1))
    _, first = np.unique(o.condition[traced], return_index=True)
    first = traced[first]
    theta, grid = corrected.physical, corrected.grid
    with_effects = forward(corrected.explanation, theta, o.v_e[first], o.f_p[first], grid)
    without = forward((), recalibrated.physical, o.v_e[first], o.f_p[first], grid)
    root = (corrected.coordinates.jacobian(corrected.u) @ corrected.root)[: len(theta)]
    random = np.random.default_rng(seed)
    drawn = random.standard_normal((DRAWS, root.shape[1])) @ root.T
    # a delay that all triggers share is as well one of the rig: a sensor's, or that of a small effect
    late_trials = (corrected.nuisance[:, TIMING] * o.nuisance_std[:, TIMING]).mean()
    delay = random.random(DRAWS) * float(corrected.common[1] + late_trials)
    error, late, gap, samples = np.zeros(DRAWS), np.zeros(DRAWS), np.zeros(DRAWS), 0
    for k, i in enumerate(first):
        recorded = int(o.time[i, o.used[i]].max() / grid.h) + 2
        end = min(phase_end(with_effects.sensed[k], with_effects.contact[k]), recorded)
        step = max(round(o.interval[i] / grid.h), 1)
        at = slice(step, max(end, step + 1), step)
        off = drawn @ with_effects.tangents[k, : len(theta), at]
        difference = without.sensed[k, at] - with_effects.sensed[k, at]
        error += (off**2).sum(1)
        late += (delay**2) * (np.gradient(with_effects.sensed[k], grid.h)[at] ** 2).sum()
        gap += ((difference - off) ** 2).sum(1)
        samples += len(difference)
    return error / samples, late / samples, np.maximum(gap / samples, 1e-12)


def peak_shrinkage(held: tuple[HeldOut, HeldOut], condition: np.ndarray, seed: int) -> Shrinkage | None:
    """Shrinkage of the relative error of the peak, from the recalibrated to the corrected model.

    The interval is that of other conditions, which differ from those that were tried as these from one another.
    """
    known = np.isfinite(held[0].peak_error)
    if not known.any():
        return None
    groups, by_group = _by_condition(condition[known], [h.peak_error[known] ** 2 for h in held])
    gap, left = by_group.sum(0)
    resampled = by_group[resample(len(groups), seed)].sum(1)
    resampled = resampled[(resampled > 0).all(1)]
    if gap <= 0 or left <= 0 or len(resampled) < RESAMPLES / 2:
        return None
    bootstrapped = resampled[:, 1] / resampled[:, 0] / (left / gap)
    factor = _as_elsewhere(bootstrapped, len(groups), np.random.default_rng(seed))
    low, high = np.quantile(np.sqrt(left / gap * factor), ENDS)
    value = 1 - np.sqrt(left / gap)
    return Shrinkage(float(value), (float(min(1 - high, value)), float(max(1 - low, value))))


def _by_condition(condition: np.ndarray, per_trial: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """The conditions, and the sums (conditions, k) of k quantities over the trials of each."""
    groups = np.unique(condition)
    table = np.stack(per_trial, axis=1)
    return groups, np.stack([table[condition == g].sum(0) for g in groups])


def resample(groups: int, seed: int, count: int = RESAMPLES) -> np.ndarray:
    """(count, groups) a bootstrap over conditions: which of them each resample takes."""
    return np.random.default_rng(seed).integers(0, groups, (count, groups))

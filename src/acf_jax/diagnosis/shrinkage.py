"""How far the gap shrinks on conditions that no fit saw, with an interval."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from acf_jax.diagnosis.heldout import TIMING, CrossValidation, HeldOut
from acf_jax.inference.fit import Fit
from acf_jax.inference.forward import forward
from acf_jax.inference.interpolation import phase_end
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import component_of, delays, is_free_curve

RESAMPLES = 2000  # of the bootstrap over conditions
DRAWS = 200  # of the parameters
ENDS = (0.025, 0.975)
SIZES = np.linspace(-4.0, 8.0, 241)  # of an error of form, in standard deviations of its logarithm
LESS = 5.0  # what is left on conditions that no trial had may be so much less
WRONG = 0.3  # of the gap may be left in addition where an explanation is wrong
LEAST_WIDTH = 0.02  # of an interval of the peak's shrinkage, to each side


@dataclass(frozen=True)
class Shrinkage:
    """1 - corrected/recalibrated with a 95 % interval."""

    value: float
    ci95: tuple[float, float]


class Form(NamedTuple):
    """How far off the form of an explanation is by experience, as a share of the gap (docs/method.md)."""

    usual: float  # median
    spread: float  # standard deviation of its logarithm
    more: float  # what is left on conditions that no trial had may be so many times as much
    beyond: float  # and what may come in addition there, or fall away
    stretch: float  # by how much the interval for the peak is wider than the bootstrap's
    wrong: float = 0.0  # what may come in addition because the explanation may be wrong


LAW = Form(0.03, 1.2, 1.1, 0.04, 1.3)
LATE = LAW._replace(beyond=0.3)  # a law much like a delay: no fit compares the first samples
FREE = Form(0.1, 1.2, 2.0, 0.4, 4.0)  # a free curve


def form_of(corrected: Fit, probability: float) -> Form:
    """How far off the form of a corrected model may be, whose explanation has this probability."""
    law = LATE if delays(corrected.explanation) else LAW
    form = FREE if is_free_curve(corrected.explanation) else law
    return form._replace(wrong=WRONG * (1 - probability))


def held_out_shrinkage(
    validation: CrossValidation, corrected: Fit, probability: float, seed: int
) -> Shrinkage | None:
    """How far the gap of the recalibrated model shrinks with a corrected one, whose cause is as probable."""
    if not validation.is_possible:
        return None
    fits = validation.recalibrated, corrected
    held = validation.of(validation.recalibrated), validation.of(corrected)
    return force_shrinkage(validation.observations, fits, held, form_of(corrected, probability), seed)


def force_shrinkage(
    observations: Observations,
    fits: tuple[Fit, Fit],
    held: tuple[HeldOut, HeldOut],
    form: Form,
    seed: int,
) -> Shrinkage | None:
    """Shrinkage of the force error, what no model can predict removed in quadrature.

    **Arguments:** `fits`, `held`: of the recalibrated and of the corrected model.

    What the corrected model leaves is the effect of parameters that the trials do not determine, as their covariance
    has it, and an error of its form, of which only experience says how large it may be. The conditions held out decide
    between the sizes: the mean square error there is known as well as a bootstrap over conditions says.

    **Returns:** median and interval of that posterior; None where the held-out conditions show no gap at all.
    """
    used = observations.traced
    recalibrated, corrected = held
    wanted = (corrected.excess, recalibrated.excess, corrected.floor, used.astype(float))
    groups, sums = _by_condition(
        observations.condition, [np.where(used, values, 0.0).sum(1) for values in wanted]
    )
    left, gap, floor, samples = sums.sum(0)
    if not samples or gap <= 0:
        return None
    draws = resample(len(groups), seed)
    resampled = sums[draws].sum(1)
    resampled = resampled[resampled[:, 3] > 0]
    unsure = max(float((resampled[:, 0] / resampled[:, 3]).std()), floor / samples * np.sqrt(2 / samples))

    error, late, gap_there = (part[:, None] for part in _possible_errors(observations, *fits, seed))
    size = form.usual * np.exp(form.spread * SIZES)
    squared = error + size**2 * gap_there
    log_weight = -0.5 * SIZES**2 - 0.5 * ((left / samples - squared) / unsure) ** 2
    weight = np.exp(log_weight - log_weight.max())
    # each trial held out was shifted to where it fits best: it says nothing of a delay common to all
    ratio = np.sqrt((squared + late) / gap_there)
    low, median, high = _quantiles(ratio, weight, (ENDS[0], 0.5, ENDS[1]))
    low, high = max(low / LESS, low - form.beyond), form.more * high + form.beyond + form.wrong
    return Shrinkage(1 - median, (1 - high, 1 - low))


def _possible_errors(
    observations: Observations, recalibrated: Fit, corrected: Fit, seed: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(DRAWS,) mean squares over the tried conditions, N^2, were a draw of the parameters the truth, to first order.

    Of the corrected model's error, of what comes to it by a delay that belongs to the sensor, and of the
    recalibrated model's error.
    """
    o = observations
    traced = np.flatnonzero(o.traced.any(1))
    _, first = np.unique(o.condition[traced], return_index=True)
    first = traced[first]
    theta, grid = corrected.physical, corrected.grid
    with_effects = forward(corrected.explanation, theta, o.v_e[first], o.f_p[first], grid)
    without = forward((), recalibrated.physical, o.v_e[first], o.f_p[first], grid)
    variance, vectors = np.linalg.eigh(corrected.covariance[: len(theta), : len(theta)])
    root = vectors * np.sqrt(np.maximum(variance, 0.0))
    random = np.random.default_rng(seed)
    drawn = random.standard_normal((DRAWS, len(theta))) @ root.T
    delay = random.random(DRAWS) * _lateness(o, corrected)
    error, late, gap, samples = np.zeros(DRAWS), np.zeros(DRAWS), np.zeros(DRAWS), 0
    for k, i in enumerate(first):
        recorded = int(o.time[i, o.used[i]].max() / grid.h) + 2
        end = min(phase_end(with_effects.sensed[k], with_effects.contact[k]), recorded)
        off = drawn @ with_effects.tangents[k, : len(theta), :end]
        difference = without.sensed[k, :end] - with_effects.sensed[k, :end]
        error += (off**2).sum(1)
        late += (delay**2) * (np.gradient(with_effects.sensed[k, :end], grid.h) ** 2).sum()
        gap += ((difference - off) ** 2).sum(1)
        samples += end
    return error / samples, late / samples, np.maximum(gap / samples, 1e-12)


def _lateness(observations: Observations, corrected: Fit) -> float:
    """The delay, s, common to all trials, where a sensor could have caused it: it may belong to the sensor's form."""
    if not any(component_of(name) == "sensor" for name in corrected.explanation):
        return 0.0
    late = (corrected.nuisance[:, TIMING] * observations.nuisance_std[:, TIMING]).mean()
    return float(corrected.common[1] + late)


def _quantiles(values: np.ndarray, weights: np.ndarray, shares: tuple[float, ...]) -> list[float]:
    order = np.argsort(values, axis=None)
    total = np.cumsum(weights.ravel()[order])
    at = np.searchsorted(total, np.array(shares) * total[-1])
    return [float(v) for v in values.ravel()[order][at]]


def peak_shrinkage(
    held: tuple[HeldOut, HeldOut], condition: np.ndarray, form: Form, seed: int
) -> Shrinkage | None:
    """Shrinkage of the relative error of the peak, from the recalibrated to the corrected model.

    The interval is a bootstrap over conditions, widened.
    """
    known = np.isfinite(held[0].peak_error)
    if not known.any():
        return None
    groups, by_group = _by_condition(condition[known], [h.peak_error[known] ** 2 for h in held])

    def shrink(total: np.ndarray) -> np.ndarray:
        gap = total[..., 0]
        return 1 - np.sqrt(total[..., 1] / np.where(gap > 0, gap, np.nan))

    value = float(shrink(by_group.sum(0)))
    values = shrink(by_group[resample(len(groups), seed)].sum(1))
    values = values[np.isfinite(values)]
    if not np.isfinite(value) or values.size < RESAMPLES / 2:
        return None
    low, high = np.quantile(values, ENDS)
    low, high = min(low, value - LEAST_WIDTH), max(high, value + LEAST_WIDTH)
    low, high = (value + form.stretch * (end - value) for end in (low, high))
    return Shrinkage(value, (float(low), float(min(high, 1.0))))


def _by_condition(condition: np.ndarray, per_trial: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """The conditions, and the sums (conditions, k) of k quantities over the trials of each."""
    groups = np.unique(condition)
    table = np.stack(per_trial, axis=1)
    return groups, np.stack([table[condition == g].sum(0) for g in groups])


def resample(groups: int, seed: int, count: int = RESAMPLES) -> np.ndarray:
    """(count, groups) a bootstrap over conditions: which of them each resample takes."""
    return np.random.default_rng(seed).integers(0, groups, (count, groups))

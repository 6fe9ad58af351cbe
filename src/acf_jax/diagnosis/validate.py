"""How good a model is on conditions that its fit did not see, and by how much the gap shrinks."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from acf_jax.diagnosis.fit import N_OWN, Fit, fit, linearise
from acf_jax.diagnosis.forward import forward, reach_of
from acf_jax.diagnosis.observe import Observations
from acf_jax.diagnosis.sample import peak_of

RESAMPLES = 2000  # of the bootstrap over conditions
TIMING, LATEST = (
    2,
    3.0,
)  # the nuisance that is the trigger time, and its farthest, in prior standard deviations
DRAWS = 64  # of noise, for the expected largest reading
# Unseen conditions lie further out than those left out one by one: intervals are as much wider, more so where a free
# form is continued instead of a law.
EXTRAPOLATION, FREE_EXTRAPOLATION = 1.3, 4.0
LEAST_WIDTH = 0.02  # of an interval of the shrinkage, to each side


@dataclass(frozen=True)
class HeldOut:
    """Predictions of every trial by a fit that did not see its condition, at the commanded velocity and pretension."""

    residual: np.ndarray  # (trials, n) N, measured minus predicted, zero where unused
    floor: np.ndarray  # (trials, n) N^2, variance that no model can predict: noise and trial-to-trial spread
    peak: np.ndarray  # (trials,) N, largest reading as predicted, what noise adds to it included
    measured_peak: np.ndarray  # (trials,) N


def hold_out(
    observations: Observations,
    fitted: Fit,
    measured_peak: np.ndarray,
    scattered: Fit,
    refit: bool = True,
) -> HeldOut:
    """Leave one condition out at a time, refit the rest from the full fit, and predict what was left out.

    With `refit` false the parameters stay at the prior, as for the paper's model before any fit. `scattered` is the fit
    whose nuisances say how much velocity, pretension and trigger really vary from trial to trial.
    """
    o = observations
    residual, floor, peak = np.zeros_like(o.force), np.zeros_like(o.force), np.zeros(len(o.names))
    for condition in np.unique(o.condition):
        out = o.condition == condition
        left = o.subset(out)
        seen = out if out.all() else ~out
        theta = fitted.theta
        if refit and not out.all():
            kept = fitted.own[seen]
            theta = fit(o.subset(seen), fitted.explanation, theta, kept, warm=True, iterations=12).theta
        reach = reach_of(fitted.explanation, theta[:-1], o.v_e[seen], o.f_p[seen], fitted.grid)
        u = fitted.coordinates.coordinate(theta)
        own = np.zeros((out.sum(), N_OWN))
        predict = partial(
            linearise, left, fitted.explanation, fitted.coordinates, u, grid=fitted.grid, reach=reach
        )
        linear = predict(own)
        # when the recording was triggered is no model's business: each trial is shifted to where it fits best
        timing = linear.by_own[:, TIMING]
        shift = (timing * linear.residual).sum(1) / ((timing**2).sum(1) + 1)
        own[:, TIMING] = np.clip(shift, -LATEST, LATEST)
        linear = predict(own)
        forces = forward(fitted.explanation, theta[:-1], left.v_e, left.f_p, fitted.grid, reach)
        residual[out] = np.where(left.used, left.force - linear.predicted, 0.0)
        scatter = np.einsum("ian,a->in", linear.spread[:, :TIMING] ** 2, spread_of(scattered)[:TIMING])
        floor[out] = np.where(left.used, o.noise.std**2 + scatter, 0.0)
        peak[out] = [
            peak_of(forces.sensed[i], fitted.grid.h, forces.contact[i])[0]
            if left.peak_only[i]
            else _largest_reading(linear.predicted[i][left.used[i]], o.noise.std)
            for i in range(len(left.names))
        ]
    return HeldOut(residual, floor, peak, measured_peak)


def _largest_reading(force: np.ndarray, noise_std: float) -> float:
    """The largest of noisy samples as one expects it: above the largest force by one or two deviations."""
    noise = noise_std * np.random.default_rng(0).standard_normal((DRAWS, len(force)))
    return float((force + noise).max(1).mean())


def spread_of(fitted: Fit) -> np.ndarray:
    """(3,) variance of the nuisances from trial to trial, in units of their priors and at most theirs."""
    return np.minimum((fitted.own**2).mean(0), 1.0)


@dataclass(frozen=True)
class GapFigures:
    """One row of the gap."""

    force_rms_n: float | None
    peak_rms_percent: float | None
    peak_max_percent: float | None


def figures(observations: Observations, held: HeldOut) -> GapFigures:
    """Root mean square error of force over all compared samples, and error of the peak."""
    traced = ~observations.peak_only
    used = observations.used & traced[:, None]
    force = float(np.sqrt((held.residual[used] ** 2).mean())) if used.any() else None
    relative = 100 * (held.peak / held.measured_peak - 1)
    return GapFigures(force, float(np.sqrt((relative**2).mean())), float(np.abs(relative).max()))


@dataclass(frozen=True)
class Shrinkage:
    """1 - corrected/recalibrated with a 95 % interval."""

    value: float
    ci95: tuple[float, float]


def force_shrinkage(
    observations: Observations, recalibrated: HeldOut, corrected: HeldOut, stretch: float, seed: int
) -> Shrinkage | None:
    """Shrinkage of the force error, what no model can predict removed in quadrature; bootstrap over conditions.

    `stretch`: by how much the interval is wider than the bootstrap's.
    """
    used = observations.used & ~observations.peak_only[:, None]
    if not used.any():
        return None
    weight = used.sum(1).astype(float)
    sums = [
        np.where(used, a, 0.0).sum(1)
        for a in (corrected.residual**2, recalibrated.residual**2, corrected.floor)
    ]
    return _bootstrap(observations.condition, np.stack(sums, 1), weight, stretch, seed)


def peak_shrinkage(
    recalibrated: HeldOut, corrected: HeldOut, condition: np.ndarray, stretch: float, seed: int
) -> Shrinkage | None:
    """Shrinkage of the relative error of the peak; bootstrap over conditions."""
    errors = [(held.peak / held.measured_peak - 1) ** 2 for held in (corrected, recalibrated)]
    sums = np.stack([*errors, np.zeros(len(condition))], 1)
    return _bootstrap(condition, sums, np.ones(len(condition)), stretch, seed)


def _bootstrap(
    condition: np.ndarray, sums: np.ndarray, weight: np.ndarray, stretch: float, seed: int
) -> Shrinkage | None:
    """`sums` (trials, 3): squared error corrected, recalibrated, and floor."""
    groups = np.unique(condition)
    by_group = np.stack([sums[condition == g].sum(0) for g in groups])
    weights = np.array([weight[condition == g].sum() for g in groups])

    def shrink(total: np.ndarray) -> np.ndarray:
        left, gap = total[..., 0] - total[..., 2], total[..., 1] - total[..., 2]
        ratio = np.sqrt(np.maximum(left, 0.0) / np.where(gap > 0, gap, np.nan))
        return 1 - ratio

    value = shrink(by_group.sum(0))
    if not np.isfinite(value):
        return None
    rng = np.random.default_rng(seed)
    draws = rng.integers(0, len(groups), (RESAMPLES, len(groups)))
    values = shrink(by_group[draws].sum(1))
    values = values[np.isfinite(values)]
    if values.size < RESAMPLES / 2 or not weights.all():
        return None
    # the floor is known only as well as the samples let it be: what hides below it, or is part of it, belongs to
    # the interval
    total = by_group.sum(0)
    unsure = np.array([0.0, 0.0, total[2] * np.sqrt(2 / max(weights.sum(), 1.0))])
    hidden = np.sqrt(unsure[2] / max(total[1] - total[2], 1e-300))
    low, high = np.quantile(values, [0.025, 0.975])
    low = min(low, float(value) - LEAST_WIDTH, 1 - float(hidden))
    high = max(high, float(value) + LEAST_WIDTH, float(np.nan_to_num(shrink(total + 2 * unsure), nan=1.0)))
    low, high = (value + stretch * (end - value) for end in (low, high))
    return Shrinkage(float(value), (float(low), float(min(high, 1.0))))

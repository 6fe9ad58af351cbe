"""How good a model is on conditions that its fit did not see."""

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from acf_jax.diagnosis.candidates import in_parallel
from acf_jax.gap_model import FORM_MOST
from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.forward import Forces, forward, reach_of
from acf_jax.inference.interpolation import peak_of
from acf_jax.inference.linear import linearise, motion_errors, residual_of
from acf_jax.inference.observations import TIMING, Observations
from acf_jax.inference.parameters import Explanation, parameters

LATEST = 3.0  # the farthest trigger time, in prior standard deviations
LOOKS = (25, 9, 9)  # at trigger times: a quarter of a deviation apart, as rings need, then ever closer
FORM_UNKNOWN = 1.0  # nothing is known of the peaks: they may be twice as high
CHI_SQUARE_MEDIAN = 0.455  # of one degree of freedom
DRAWS = 64  # of noise, for the expected largest reading


@dataclass(frozen=True)
class HeldOut:
    """Predictions of every trial by a fit that did not see its condition, at the commanded velocity and pretension."""

    residual: np.ndarray  # (trials, n) N, measured minus predicted, zero where unused
    floor: (
        np.ndarray
    )  # (trials, n) N^2, variance that no model can predict, between repeats or of noise and scatter
    peak: np.ndarray  # (trials,) N, largest reading as predicted, what noise adds to it included
    measured_peak: np.ndarray  # (trials,) N, nan where it is not known: the force is cut off

    @property
    def peak_error(self) -> np.ndarray:
        """(trials,) relative error of the predicted peak, nan where the measured one is not known."""
        return self.peak / np.where(self.measured_peak > 0, self.measured_peak, np.nan) - 1

    @property
    def excess(self) -> np.ndarray:
        """(trials, n) N^2, squared error beyond what no model can predict."""
        return self.residual**2 - self.floor


def hold_out(
    observations: Observations,
    fitted: Fit,
    measured_peak: np.ndarray,
    scattered: Fit,
    refit: bool = True,
) -> HeldOut:
    """Leave one condition out at a time, refit the rest from the full fit, and predict what was left out.

    With `refit` false the parameters stay as they are. `scattered` is the fit
    whose nuisances say how much velocity, pretension and trigger really vary from trial to trial.
    """
    o = observations
    conditions = [o.condition == c for c in np.unique(o.condition)]
    tasks = [partial(_predict_held_out, o, out, fitted, scattered, refit) for out in conditions]
    residual, floor, peak = np.zeros_like(o.force), np.zeros_like(o.force), np.zeros(len(o.names))
    for out, (residual_there, floor_there, peak_there) in zip(conditions, in_parallel(tasks), strict=True):
        residual[out], floor[out], peak[out] = residual_there, floor_there, peak_there
    return HeldOut(residual, floor, peak, measured_peak)


def _predict_held_out(
    o: Observations, out: np.ndarray, fitted: Fit, scattered: Fit, refit: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Residual, floor and peak of `HeldOut` for the trials `out`, after a fit to the others."""
    left = o.subset(out)
    seen = out if out.all() else ~out
    theta = fitted.theta
    if refit and not out.all():
        kept = fitted.nuisance[seen]
        again = partial(fit, o.subset(seen), fitted.explanation, program=fitted.program)
        theta = again(theta, kept, warm=True, iterations=12).theta
    physical = theta[: len(parameters(fitted.explanation))]
    reach = reach_of(fitted.explanation, physical, o.v_e[seen], o.f_p[seen], fitted.grid)
    u = fitted.coordinates.coordinate(theta)
    common = theta[len(physical) :]
    error = motion_errors(left, np.zeros((len(left.names), left.n_nuisances)), common)
    forces = forward(fitted.explanation, physical, left.v_e, left.f_p, fitted.grid, reach, left.robot, error)
    nuisance = _when_triggered(left, forces, common, fitted.grid.h)
    linear = linearise(left, fitted.explanation, fitted.coordinates, u, nuisance, fitted.grid, reach)
    if not linear.is_sound:  # a free curve goes astray there: it predicts no force at all
        nothing = np.where(left.used, left.force, 0.0), np.where(left.used, o.noise.std**2, 0.0)
        return *nothing, np.zeros(len(left.names))
    spread = np.concatenate([linear.spread, left.ringing * left.used[:, None]], axis=1)
    scatter = np.einsum(
        "ian,a->in", np.delete(spread, TIMING, 1) ** 2, np.delete(spread_of(scattered), TIMING)
    )
    peak = [
        peak_of(forces.sensed[i], fitted.grid.h, forces.contact[i])[0]
        if left.peak_only[i]
        else largest_reading(linear.predicted[i][left.used[i]], o.noise.std, left.ringing[i][:, left.used[i]])
        for i in range(len(left.names))
    ]
    residual = np.where(left.used, left.force - linear.predicted, 0.0)
    return residual, np.where(left.used, o.noise.std**2 + scatter, 0.0), np.array(peak)


def _when_triggered(left: Observations, forces: Forces, common: np.ndarray, h: float) -> np.ndarray:
    """The nuisances (trials, k), zero but for the trigger time of each trial, where its force fits best.

    When a recording was triggered is no model's business. A force that begins with a jump fits well at several times:
    all are looked at, then those about the best ones more closely.
    """
    nuisance = np.zeros((len(left.names), left.n_nuisances))

    def chi_square(times: np.ndarray) -> np.ndarray:
        nuisance[:, TIMING] = times
        return np.nan_to_num(
            (residual_of(left, forces, common, nuisance, h) ** 2).sum(1) + times**2, nan=np.inf
        )

    best, width = np.zeros(len(left.names)), LATEST
    for looks in LOOKS:
        tried = np.clip(best + width * np.linspace(-1, 1, looks)[:, None], -LATEST, LATEST)
        best = tried[np.argmin([chi_square(times) for times in tried], axis=0), np.arange(len(best))]
        width *= 2 / (looks - 1)
    nuisance[:, TIMING] = best
    return nuisance


def largest_reading(force: np.ndarray, noise_std: float, ringing: np.ndarray) -> float:
    """The largest of noisy samples as one expects it: above the largest force by one or two deviations.

    **Arguments:** `force`: (n,) N. `ringing`: (k, n) N, one standard deviation of what each trial rings with.
    """
    random = np.random.default_rng(0)
    noise = noise_std * random.standard_normal((DRAWS, len(force)))
    return float((force + noise + random.standard_normal((DRAWS, len(ringing))) @ ringing).max(1).mean())


def spread_of(fitted: Fit) -> np.ndarray:
    """(k,) variance of the nuisances from trial to trial, in units of their priors and at most theirs."""
    return np.minimum((fitted.nuisance**2).mean(0), 1.0)


@dataclass(frozen=True)
class GapFigures:
    """One row of the gap."""

    force_rms_n: float | None  # None without traces,
    peak_rms_percent: float | None  # without peaks, or where all trials have one condition
    peak_max_percent: float | None


def figures(observations: Observations, held: HeldOut) -> GapFigures:
    """Root mean square error of force over all compared samples, and error of the peak."""
    used = observations.traced
    force = float(np.sqrt((held.residual[used] ** 2).mean())) if used.any() else None
    relative = 100 * held.peak_error[np.isfinite(held.peak_error)]
    if not relative.size:
        return GapFigures(force, None, None)
    return GapFigures(force, float(np.sqrt((relative**2).mean())), float(np.abs(relative).max()))


def form_error(held: HeldOut, noise_std: float) -> float:
    """What the law itself misses of a peak on held-out conditions, as a relative standard deviation, beyond noise.

    From the median, for one condition may be missed far more than others. `FORM_UNKNOWN` where no peak is known; at
    most `FORM_MOST`.
    """
    known = np.isfinite(held.peak_error)
    if not known.any():
        return FORM_UNKNOWN
    noise = noise_std / held.measured_peak[known]
    squared = np.median(held.peak_error[known] ** 2) / CHI_SQUARE_MEDIAN - np.median(noise**2)
    return float(np.sqrt(np.clip(squared, 0.0, FORM_MOST**2)))


@dataclass(frozen=True)
class CrossValidation:
    """Predictions of one condition after the other by fits to the rest, each explanation's computed once."""

    observations: Observations
    measured_peak: np.ndarray  # (trials,) N
    recalibrated: Fit
    scattered: Fit  # says how much velocity, pretension and trigger really vary, see `hold_out`
    known: dict[Explanation, HeldOut] = field(default_factory=dict)

    @property
    def is_possible(self) -> bool:
        """Whether there is a condition that a fit to the others does not see."""
        return len(np.unique(self.observations.condition)) > 1

    def of(self, fitted: Fit) -> HeldOut:
        """The predictions of a fit; of a single condition by the fit to it."""
        name, scattered = fitted.explanation, self.scattered
        if name not in self.known:
            held = hold_out(self.observations, fitted, self.measured_peak, scattered)
            floor = (
                pure_error(self.observations, held)
                if name == scattered.explanation
                else self.of(scattered).floor
            )
            self.known[name] = replace(held, floor=floor)
        return self.known[name]


def pure_error(observations: Observations, held: HeldOut) -> np.ndarray:
    """The floor (trials, n), N^2, of conditions that were repeated: the variance of what a model leaves of the repeats.

    The mean square of what it leaves is then beyond the floor by the mean product of two different repeats, whatever
    noise, scatter and rings they have (pure error: Box, Hunter and Hunter, 'Statistics for Experimenters', 2005).
    """
    o, floor = observations, held.floor.copy()
    rate = _rates(o)
    for condition, own in set(zip(o.condition.tolist(), rate.tolist(), strict=True)):
        there = (o.condition == condition) & (rate == own)
        used = o.traced[there]
        count = used.sum(0)
        mean = np.where(used, held.residual[there], 0.0).sum(0) / np.maximum(count, 1)
        variance = (np.where(used, held.residual[there] - mean, 0.0) ** 2).sum(0) / np.maximum(count - 1, 1)
        floor[there] = np.where(used & (count > 1), variance, floor[there])
    return floor


def _rates(o: Observations) -> np.ndarray:
    """(trials,) int, alike where samples of one number are read at one time: to within one interval, to the last."""
    intervals, which = np.unique(o.interval, return_inverse=True)
    drift = o.traced.shape[1] * np.diff(intervals, prepend=intervals[:1])
    return np.asarray(np.cumsum(drift > intervals)[which])

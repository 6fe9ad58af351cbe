"""The model about one point: whitened residuals and their derivatives, normal equations, and half the chi-square.

Each trial has nuisances with normal priors: the true contact velocity and pretension about the commanded ones, the
trigger time, the errors of a measured motion, and two parts of each ring. They are eliminated by their Schur
complement, so the cost is linear in trials.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from acf_jax.inference.censoring import at_least
from acf_jax.inference.forward import Forces, Grid, forward, forward_plain
from acf_jax.inference.interpolation import combine, combine_row, peak_of, taps
from acf_jax.inference.observations import N_NUISANCE, Observations, Waves
from acf_jax.inference.parameters import COMMON, Coordinates, Explanation, parameters

BEYOND = 6  # steps after the last sample of a trial, to tell either side of a loss of contact right there
LARGEST = 1e7  # residuals and derivatives beyond it, in units of the noise, come from an unstable integration


def is_bounded(values: np.ndarray) -> bool:
    """Whether residuals or derivatives, in units of the noise, come from a stable integration."""
    # what is not a number is neither
    return bool(values.max(initial=0.0) < LARGEST and values.min(initial=0.0) > -LARGEST)


@dataclass(frozen=True)
class Linearisation:
    """Whitened residuals and derivatives of every trial at one point."""

    residual: np.ndarray  # (trials, n) whitened measured minus predicted
    by_law: np.ndarray  # (trials, p - w, n) whitened derivative of the prediction in u, but for shared waves
    by_motion: np.ndarray  # (trials, 3 + q, n) the same in the nuisances that change the motion
    waves: Waves  # the same in all others, that of the observations at every point, but for bounds
    predicted: np.ndarray  # (trials, n) N
    spread: np.ndarray  # (trials, 3 + q, n) N, change of the force by one standard deviation of those

    @cached_property
    def by_parameter(self) -> np.ndarray:
        """(trials, p, n) whitened derivative of the prediction in u."""
        return np.concatenate([self.by_law, self.waves.shared], axis=1)

    @cached_property
    def by_nuisance(self) -> np.ndarray:
        """(trials, q, n) whitened derivative of the prediction in the trial's nuisances."""
        return np.concatenate([self.by_motion, self.waves.own], axis=1)

    @property
    def is_sound(self) -> bool:
        """Whether the integration was stable."""
        return all(map(is_bounded, (self.residual, self.by_law, self.by_motion)))

    def of(self, trials: np.ndarray) -> "Linearisation":
        """That of some trials, given by index."""
        return Linearisation(
            self.residual[trials],
            self.by_law[trials],
            self.by_motion[trials],
            self.waves.of(trials),
            self.predicted[trials],
            self.spread[trials],
        )


def linearise(
    observations: Observations,
    explanation: Explanation,
    at: Coordinates,
    u: np.ndarray,
    nuisance: np.ndarray,
    grid: Grid,
    reach: float = np.inf,
) -> Linearisation:
    """Run the simulator and compare it with the measured samples; `reach` is that of `forward`."""
    theta, count = at.value(u), len(parameters(explanation))
    forces = _forces(observations, explanation, theta, nuisance, grid, reach)
    with np.errstate(over="ignore", invalid="ignore"):  # an unstable integration is told by its objective
        return compare(observations, forces, at.jacobian(u), theta[count:], nuisance, grid.h)


def residuals(
    o: Observations, explanation: Explanation, theta: np.ndarray, nuisance: np.ndarray, grid: Grid
) -> np.ndarray:
    """(k, trials, n) the whitened residuals alone, of parameters (k, p) in SI units that share what is common.

    A fraction of the time of `linearise`, and one compiled program for all explanations. Trials of one condition have
    the force of their mean: two residuals tell what parameters change.
    """
    p, n = len(parameters(explanation)), int(o.simulated.max()) + 1
    common = theta[0, p:]
    at, each = _impacts(o, nuisance, common, grid.h), np.tile(np.arange(n), len(theta))
    v_e, f_p = at.mean[each].T
    error = None if at.error is None else at.error[each]
    robot, steps = o.robot and o.robot.of(each), at.steps[each]
    found = forward_plain(
        explanation, np.repeat(theta[:, :p], n, axis=0), v_e, f_p, grid, robot, error, steps
    )
    of_trials = (Forces(*(part[k + o.simulated] for part in found)) for k in range(0, len(each), n))
    return np.stack([residual_of(o, forces, common, nuisance, grid.h) for forces in of_trials])


def residual_of(
    observations: Observations, forces: Forces, common: np.ndarray, nuisance: np.ndarray, h: float
) -> np.ndarray:
    """(trials, n) the whitened residual of simulated forces, of whose nuisances trigger times and rings count."""
    o = observations
    with np.errstate(over="ignore", invalid="ignore"):
        left, _ = _left(o, _sensed(o, forces, common, nuisance, h))
        return o.whiten((left * o.weighed)[:, None])[:, 0]


def predict(
    observations: Observations, explanation: Explanation, theta: np.ndarray, nuisance: np.ndarray, grid: Grid
) -> np.ndarray:
    """(trials, n) N, the force alone, of parameters in SI units."""
    o, common = observations, theta[len(parameters(explanation)) :]
    forces = _forces(o, explanation, theta, nuisance, grid)
    with np.errstate(over="ignore", invalid="ignore"):
        return _sensed(o, forces, common, nuisance, grid.h)


def _sensed(
    o: Observations, forces: Forces, common: np.ndarray, nuisance: np.ndarray, h: float
) -> np.ndarray:
    """(trials, n) N, the simulated forces at the measured times, with what comes to them beside the motion."""
    at = taps(_times(o, forces, common, nuisance, h), h, forces.contact)
    return combine_row(forces.sensed, at.near, at.weight) + _beside_motion(o, common, nuisance)


def predict_as_commanded(
    observations: Observations, explanation: Explanation, physical: np.ndarray, grid: Grid
) -> np.ndarray:
    """(trials, n) N, the force of rig and laws alone, p numbers in SI units: no nuisance, zero, delay or wave."""
    o = observations
    theta = np.concatenate([physical, np.zeros(o.n_common + o.n_shared)])
    return predict(o, explanation, theta, np.zeros((len(o.names), o.n_nuisances)), grid)


def _forces(
    o: Observations,
    explanation: Explanation,
    theta: np.ndarray,
    nuisance: np.ndarray,
    grid: Grid,
    reach: float = np.inf,
) -> Forces:
    physical, common = np.split(theta, [len(parameters(explanation))])
    at = _impacts(o, nuisance, common, grid.h)
    v_e, f_p = at.mean.T
    found = forward(explanation, physical, v_e, f_p, grid, reach, o.robot, at.error, at.steps)
    rows = found.rows[o.simulated]
    slopes = rows[:, 1 + len(physical) : 3 + len(physical)]
    with np.errstate(over="ignore", invalid="ignore"):  # of an unstable integration
        rows[:, 0] += (at.beside[:, None] @ slopes)[:, 0]
    return Forces(found.contact[o.simulated], rows)


class _Impacts(NamedTuple):
    """What is simulated: conditions at the mean of their trials, which are to first order beside it.

    In velocity and pretension the paper's model is linear, and laws bend little where repeats differ.
    """

    mean: np.ndarray  # (simulated, 2) m/s, N
    beside: np.ndarray  # (trials, 2) the same, of each trial less that
    error: np.ndarray | None  # (simulated, q) of a measured motion, of which each trial is simulated
    steps: np.ndarray  # (simulated,) that each needs


def _impacts(o: Observations, nuisance: np.ndarray, common: np.ndarray, h: float) -> _Impacts:
    impacts = np.column_stack([o.v_e, o.f_p]) + nuisance[:, :2] * o.nuisance_std[:, :2]
    steps = steps_of(o, h)
    mean = np.zeros((len(steps), 2))
    np.add.at(mean, o.simulated, impacts)
    mean /= np.bincount(o.simulated)[:, None]
    error = motion_errors(o, nuisance, common) if o.robot else None
    return _Impacts(mean, impacts - mean[o.simulated], error, steps)


def motion_errors(o: Observations, nuisance: np.ndarray, common: np.ndarray) -> np.ndarray:
    """(trials, q) by how many standard deviations a measured motion is off: of each trial, and that of all."""
    late = np.tile(common[COMMON : o.n_common], (len(nuisance), 1))
    return np.hstack([nuisance[:, N_NUISANCE : o.n_moving], late])


def steps_of(o: Observations, h: float) -> np.ndarray:
    """(simulated,) steps of `h` s that each simulation needs."""
    ends = np.zeros(o.simulated.max() + 1)
    np.maximum.at(ends, o.simulated, o.ends)
    return np.ceil(ends / h).astype(int) + BEYOND


def _times(o: Observations, forces: Forces, common: np.ndarray, nuisance: np.ndarray, h: float) -> np.ndarray:
    """(trials, n) s after first contact, of each sample; that of the peak where only this was measured."""
    times = o.time - (common[1] + nuisance[:, 2] * o.nuisance_std[:, 2])[:, None]
    for i in np.flatnonzero(o.peak_only):
        times[i, 0] = peak_of(forces.sensed[i], h, forces.contact[i])[1]
    return times


def _beside_motion(o: Observations, common: np.ndarray, nuisance: np.ndarray) -> np.ndarray:
    """(trials, n) N: the sensor's zero, rings, and waves of a discrepancy."""
    zero = common[0] * ~o.peak_only[:, None]
    shared = np.einsum("k,ikn->in", common[o.n_common :], o.shared)
    return zero + shared + (nuisance[:, None, o.n_moving :] @ o.ringing)[:, 0]


def _left(o: Observations, predicted: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
    """(trials, n) N, what a prediction leaves, and the share of its derivatives that counts; None: all of all."""
    left = o.force - predicted
    if o.censored is None:
        return left, None
    bound, slope = at_least(-left / o.noise.std)
    return np.where(o.censored, o.noise.std * bound, left), np.where(o.censored, slope, 1.0)


def compare(
    o: Observations,
    forces: Forces,
    jacobian: np.ndarray,
    common: np.ndarray,
    nuisance: np.ndarray,
    h: float,
) -> Linearisation:
    """The simulated forces at the measured times, with derivatives, whitened."""
    p, q = len(jacobian) - len(common), o.n_moving - N_NUISANCE
    spread = o.nuisance_std
    at = taps(_times(o, forces, common, nuisance, h), h, forces.contact)
    found = combine(forces.rows, at.near, at.weight)
    predicted, tangents = found[:, 0] + _beside_motion(o, common, nuisance), found[:, 1:]
    timing = -combine_row(forces.sensed, at.near, at.rate_weight(h)) * ~o.peak_only[:, None]

    first = 1 + p + o.n_common  # row of a nuisance
    rows = np.empty((len(o.names), first + o.n_moving, o.force.shape[1]))
    rows[:, 0], share = _left(o, predicted)
    rows[:, 1 : p + 1] = jacobian[:p, :p].T @ tangents[:, :p]
    rows[:, p + 1] = jacobian[p, p] * ~o.peak_only[:, None]
    rows[:, p + 2] = timing * jacobian[p + 1, p + 1]
    rows[:, p + 3 : first] = tangents[:, p + 2 + q :]
    rows[:, first : first + 2] = tangents[:, p : p + 2] * spread[:, :2, None]
    rows[:, first + 2] = timing * spread[:, 2:3]
    rows[:, first + N_NUISANCE :] = tangents[:, p + 2 : p + 2 + q]
    waves = o.whitened_waves
    if share is not None:
        rows[:, 1:] *= share[:, None]
        waves = o.whiten_waves(share)
    rows *= o.weighed[:, None]
    white = o.whiten(rows)
    return Linearisation(
        white[:, 0],
        white[:, 1:first],
        white[:, first:],
        waves,
        predicted * o.used,
        rows[:, first:] * o.used[:, None],
    )


@dataclass(frozen=True)
class Normal:
    """Normal equations with the nuisances eliminated."""

    hessian: np.ndarray
    gradient: np.ndarray
    nuisance_inverse: np.ndarray
    nuisance_gradient: np.ndarray
    cross: np.ndarray

    @property
    def nuisance_gain(self) -> float:
        """Chi-square that one step of the nuisances takes, to first order."""
        return float(
            np.einsum("ia,iab,ib->", self.nuisance_gradient, self.nuisance_inverse, self.nuisance_gradient)
        )

    @property
    def gain(self) -> float:
        """Chi-square that one step of everything takes, to first order."""
        return self.nuisance_gain + float(self.gradient @ np.linalg.solve(self.hessian, self.gradient))

    def expected(self, step: np.ndarray) -> float:
        """Half the chi-square that a step of the parameters and the nuisances' answer take, to first order."""
        return 0.5 * self.nuisance_gain - float(self.gradient @ step + 0.5 * step @ self.hessian @ step)


def normal_equations(
    linear: Linearisation, u: np.ndarray, nuisance: np.ndarray, inflation: float = 1.0
) -> Normal:
    """With the noise variance multiplied by `inflation`."""
    gram, m, k = _gram(linear) / inflation, linear.by_motion.shape[1], linear.waves.own.shape[1]
    moved, law = slice(m + k), slice(m + k, -1)
    nuisance_inverse = np.linalg.inv(gram[:, moved, moved] + np.eye(m + k))
    nuisance_gradient = nuisance - gram[:, moved, -1]
    cross = gram[:, law, moved]
    reduced = cross @ nuisance_inverse
    hessian = gram[:, law, law].sum(0) - np.einsum("ipb,iqb->pq", reduced, cross) + np.eye(len(u))
    gradient = u - gram[:, law, -1].sum(0) - np.einsum("ipb,ib->p", reduced, nuisance_gradient)
    return Normal(hessian, gradient, nuisance_inverse, nuisance_gradient, cross)


def _gram(linear: Linearisation) -> np.ndarray:
    """(trials, s, s) inner products of all signals: nuisances, then parameters, then the residual.

    Those of the waves among one another are known: only what changes from point to point is multiplied.
    """
    waves, m, a = linear.waves, linear.by_motion.shape[1], linear.by_law.shape[1]
    k, count = waves.own.shape[1], m + a + 1 + waves.both.shape[1]
    same = np.r_[m : m + k, m + k + a : count - 1]
    new = np.setdiff1d(np.arange(count), same)
    signals = np.concatenate([linear.by_motion, linear.by_law, linear.residual[:, None]], axis=1)
    gram = np.empty((len(signals), count, count))
    gram[:, new[:, None], new] = signals @ signals.swapaxes(1, 2)
    gram[:, same[:, None], same] = waves.gram
    across = signals @ waves.both.swapaxes(1, 2)
    gram[:, new[:, None], same] = across
    gram[:, same[:, None], new] = across.swapaxes(1, 2)
    return gram


def half_chi_square(
    linear: Linearisation, u: np.ndarray, nuisance: np.ndarray, inflation: float = 1.0
) -> float:
    """Half chi-square of data, nuisances and priors; infinite where the simulation has broken down."""
    if not linear.is_sound:
        return np.inf
    return 0.5 * float((linear.residual**2).sum() / inflation + (nuisance**2).sum() + (u**2).sum())

"""The model about one point: whitened residuals and their derivatives, normal equations, and half the chi-square.

Each trial has nuisances with normal priors: the true contact velocity and pretension about the commanded ones, the
trigger time, the errors of a measured motion, and two parts of each ring. They are eliminated by their Schur
complement, so the cost is linear in trials.
"""

from dataclasses import dataclass, fields

import numpy as np

from acf_jax.inference.censoring import at_least
from acf_jax.inference.forward import Forces, Grid, forward
from acf_jax.inference.interpolation import combine, combine_row, peak_of, taps
from acf_jax.inference.observations import N_NUISANCE, Observations
from acf_jax.inference.parameters import COMMON, Coordinates, Explanation, parameters

LARGEST = 1e7  # residuals and derivatives beyond it, in units of the noise, come from an unstable integration


def is_bounded(values: np.ndarray) -> bool:
    """Whether residuals or derivatives, in units of the noise, come from a stable integration."""
    return bool(np.abs(values).max(initial=0.0) < LARGEST)  # not a number is not smaller either


@dataclass(frozen=True)
class Linearisation:
    """Whitened residuals and derivatives of every trial at one point."""

    residual: np.ndarray  # (trials, n) whitened measured minus predicted
    by_parameter: np.ndarray  # (trials, p, n) whitened derivative of the prediction in u
    by_motion: np.ndarray  # (trials, 3 + q, n) the same in the nuisances that change the motion
    by_ringing: (
        np.ndarray
    )  # (trials, k, n) in all others: that of the observations at every point, but for bounds
    predicted: np.ndarray  # (trials, n) N
    spread: np.ndarray  # (trials, 3 + q, n) N, change of the force by one standard deviation of those

    @property
    def by_nuisance(self) -> np.ndarray:
        """(trials, q, n) whitened derivative of the prediction in the trial's nuisances."""
        return np.concatenate([self.by_motion, self.by_ringing], axis=1)

    @property
    def is_sound(self) -> bool:
        """Whether the integration was stable."""
        return all(map(is_bounded, (self.residual, self.by_parameter, self.by_motion)))

    def of(self, trials: np.ndarray) -> "Linearisation":
        """That of some trials, given by index."""
        return Linearisation(*(getattr(self, field.name)[trials] for field in fields(self)))


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
        return compare(observations, forces, at.slope(u), theta[count:], nuisance, grid.h)


def residual(
    observations: Observations, explanation: Explanation, theta: np.ndarray, nuisance: np.ndarray, grid: Grid
) -> np.ndarray:
    """(trials, n) the whitened residual alone, of parameters in SI units: a fraction of the time of `linearise`."""
    o = observations
    with np.errstate(over="ignore", invalid="ignore"):
        left, _ = _left(o, predict(o, explanation, theta, nuisance, grid))
        return o.whiten((left * o.weighed)[:, None])[:, 0]


def predict(
    observations: Observations, explanation: Explanation, theta: np.ndarray, nuisance: np.ndarray, grid: Grid
) -> np.ndarray:
    """(trials, n) N, the force alone, of parameters in SI units."""
    o, common = observations, theta[len(parameters(explanation)) :]
    forces = _forces(o, explanation, theta, nuisance, grid)
    with np.errstate(over="ignore", invalid="ignore"):
        at = taps(_times(o, forces, common, nuisance, grid.h), grid.h, forces.contact)
        return combine_row(forces.sensed, at.near, at.weight) + _beside_motion(o, common, nuisance)


def _forces(
    o: Observations,
    explanation: Explanation,
    theta: np.ndarray,
    nuisance: np.ndarray,
    grid: Grid,
    reach: float = np.inf,
) -> Forces:
    shift = nuisance[:, : o.n_moving] * o.nuisance_std
    physical, common = np.split(theta, [len(parameters(explanation))])
    late = np.tile(common[COMMON : o.n_common], (len(shift), 1))  # of the robot's motion
    v_e, f_p, error = o.v_e + shift[:, 0], o.f_p + shift[:, 1], np.hstack([shift[:, N_NUISANCE:], late])
    return forward(explanation, physical, v_e, f_p, grid, reach, o.robot, error)


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
    slope: np.ndarray,
    common: np.ndarray,
    nuisance: np.ndarray,
    h: float,
) -> Linearisation:
    """The simulated forces at the measured times, with derivatives, whitened."""
    p, q = len(slope) - len(common), o.n_moving - N_NUISANCE
    spread = o.nuisance_std
    at = taps(_times(o, forces, common, nuisance, h), h, forces.contact)
    found = combine(forces.rows, at.near, at.weight)
    predicted, tangents = found[:, 0] + _beside_motion(o, common, nuisance), found[:, 1:]
    timing = -combine_row(forces.sensed, at.near, at.rate_weight(h)) * ~o.peak_only[:, None]

    first = 1 + p + o.n_common  # row of a nuisance
    rows = np.empty((len(o.names), first + o.n_moving, o.force.shape[1]))
    rows[:, 0], share = _left(o, predicted)
    rows[:, 1 : p + 1] = tangents[:, :p] * slope[:p, None]
    rows[:, p + 1] = slope[p] * ~o.peak_only[:, None]
    rows[:, p + 2] = timing * slope[p + 1]
    rows[:, p + 3 : first] = tangents[:, p + 2 + q :]
    rows[:, first : first + 2] = tangents[:, p : p + 2] * spread[:, :2, None]
    rows[:, first + 2] = timing * spread[:, 2:3]
    rows[:, first + N_NUISANCE :] = tangents[:, p + 2 : p + 2 + q]
    ringing, shared = o.whitened_ringing, o.whitened_shared
    if share is not None:
        rows[:, 1:] *= share[:, None]
        ringing, shared = (o.whiten(waves * (share * o.weighed)[:, None]) for waves in (o.ringing, o.shared))
    rows *= o.weighed[:, None]
    white = o.whiten(rows)
    return Linearisation(
        white[:, 0],
        np.concatenate([white[:, 1:first], shared], axis=1),
        white[:, first:],
        ringing,
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


def normal_equations(
    linear: Linearisation, u: np.ndarray, nuisance: np.ndarray, inflation: float = 1.0
) -> Normal:
    """With the noise variance multiplied by `inflation`."""
    r, j, k = (a / np.sqrt(inflation) for a in (linear.residual, linear.by_parameter, linear.by_nuisance))
    across = k.swapaxes(1, 2)
    nuisance_inverse = np.linalg.inv(k @ across + np.eye(k.shape[1]))
    nuisance_gradient = nuisance - (k @ r[:, :, None])[:, :, 0]
    cross = j @ across
    reduced = cross @ nuisance_inverse
    hessian = (
        np.einsum("ipn,iqn->pq", j, j, optimize=True)
        - np.einsum("ipb,iqb->pq", reduced, cross)
        + np.eye(len(u))
    )
    gradient = u - np.einsum("ipn,in->p", j, r) - np.einsum("ipb,ib->p", reduced, nuisance_gradient)
    return Normal(hessian, gradient, nuisance_inverse, nuisance_gradient, cross)


def half_chi_square(
    linear: Linearisation, u: np.ndarray, nuisance: np.ndarray, inflation: float = 1.0
) -> float:
    """Half chi-square of data, nuisances and priors; infinite where the simulation has broken down."""
    if not linear.is_sound:
        return np.inf
    return 0.5 * float((linear.residual**2).sum() / inflation + (nuisance**2).sum() + (u**2).sum())

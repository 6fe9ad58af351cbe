"""The model about one point: whitened residuals and their derivatives, normal equations, and half the chi-square.

Each trial has nuisances with normal priors: the true contact velocity and pretension about the commanded ones, the
trigger time, and two parts of each ring. They are eliminated by their Schur complement, so the cost is linear in
trials.
"""

from dataclasses import dataclass, fields

import numpy as np

from acf_jax.inference.forward import Forces, Grid, forward
from acf_jax.inference.interpolation import combine, peak_of, taps
from acf_jax.inference.observations import N_NUISANCE, Observations
from acf_jax.inference.parameters import COMMON, Coordinates, Explanation

LARGEST = 1e7  # residuals and derivatives beyond it, in units of the noise, come from an unstable integration


def is_bounded(values: np.ndarray) -> bool:
    """Whether residuals or derivatives, in units of the noise, come from a stable integration."""
    return bool(np.abs(values).max(initial=0.0) < LARGEST)  # not a number is not smaller either


@dataclass(frozen=True)
class Linearisation:
    """Whitened residuals and derivatives of every trial at one point."""

    residual: np.ndarray  # (trials, n) whitened measured minus predicted
    by_parameter: np.ndarray  # (trials, p, n) whitened derivative of the prediction in u
    by_nuisance: np.ndarray  # (trials, q, n) in the trial's nuisances
    predicted: np.ndarray  # (trials, n) N
    spread: np.ndarray  # (trials, q, n) N, change of the force by one standard deviation of each nuisance

    @property
    def is_sound(self) -> bool:
        """Whether the integration was stable."""
        return all(map(is_bounded, (self.residual, self.by_parameter, self.by_nuisance)))

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
    o = observations
    spread = o.nuisance_std
    shift = nuisance[:, :N_NUISANCE] * spread
    theta = at.value(u)
    physical, common = theta[:-COMMON], theta[-COMMON:]
    forces = forward(explanation, physical, o.v_e + shift[:, 0], o.f_p + shift[:, 1], grid, reach)
    with np.errstate(over="ignore", invalid="ignore"):  # an unstable integration is told by its objective
        return compare(o, forces, at.slope(u), common, nuisance, grid.h)


def compare(
    o: Observations,
    forces: Forces,
    slope: np.ndarray,
    common: np.ndarray,
    nuisance: np.ndarray,
    h: float,
) -> Linearisation:
    """The simulated forces at the measured times, with derivatives, whitened."""
    p = len(slope) - COMMON
    zero, delay = common
    spread, ringing = o.nuisance_std, o.ringing
    times = o.time - (delay + nuisance[:, 2] * spread[:, 2])[:, None]
    for i in np.flatnonzero(o.peak_only):
        times[i, 0] = peak_of(forces.sensed[i], h, forces.contact[i])[1]
    near, weight, rate_weight = taps(times, h, forces.contact)
    at = combine(forces.rows, near, weight)
    predicted, tangents = at[:, 0] + zero * ~o.peak_only[:, None], at[:, 1:]
    predicted += np.einsum("ir,irn->in", nuisance[:, N_NUISANCE:], ringing)
    timing = -combine(forces.rows[:, :1], near, rate_weight)[:, 0] * ~o.peak_only[:, None]

    first = 1 + p + COMMON  # row of a nuisance
    rows = np.empty((len(o.names), first + o.n_nuisances, o.force.shape[1]))
    rows[:, 0] = o.force - predicted
    rows[:, 1 : p + 1] = tangents[:, :p] * slope[:p, None]
    rows[:, p + 1] = slope[p] * ~o.peak_only[:, None]
    rows[:, p + 2] = timing * slope[p + 1]
    rows[:, first : first + 2] = tangents[:, p:] * spread[:, :2, None]
    rows[:, first + 2] = timing * spread[:, 2:]
    rows[:, first + N_NUISANCE :] = ringing
    rows *= o.used[:, None]
    scatter = rows[:, first:].copy()
    rows = o.whiten(rows)
    return Linearisation(rows[:, 0], rows[:, 1:first], rows[:, first:], predicted * o.used, scatter)


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
    nuisance_inverse = np.linalg.inv(np.einsum("ian,ibn->iab", k, k) + np.eye(k.shape[1]))
    nuisance_gradient = nuisance - np.einsum("ian,in->ia", k, r)
    cross = np.einsum("ipn,ian->ipa", j, k)
    reduced = np.einsum("ipa,iab->ipb", cross, nuisance_inverse)
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

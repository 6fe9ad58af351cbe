"""Fitting one explanation to all trials at once: Levenberg-Marquardt within bounds, under the rig's priors."""

from dataclasses import dataclass

import numpy as np

from acf_jax.inference import unfinished
from acf_jax.inference.forward import SAMPLES, Grid, block_for, step_for
from acf_jax.inference.linear import (
    BEYOND,
    Linearisation,
    half_chi_square,
    linearise,
    normal_equations,
    predict,
    steps_of,
)
from acf_jax.inference.observations import COMMON_TRIGGER, NO_TIME, TIMING, Observations
from acf_jax.inference.parameters import (
    COMMON,
    Coordinates,
    Explanation,
    classes,
    coordinates,
    delays,
    parameters,
)

STRIDE = 2.0  # sampling intervals of its longest step
RESOLVED = 0.1  # periods of a filter's cutoff: its longest step
RINGING, LAGGING = 1.0, 1 / 3  # the same where a sensor has dynamics of its own, and where it follows late
COARSEST = 100.0  # a fit stops at up to so much larger a gain, the farther it is from the data
ITERATIONS = 40  # of a fit, at most
TOLERANCE = 1e-5  # share of the objective that an iteration has to gain
ENOUGH = 2  # iterations that gain less, where more is promised or their steps are damped
CERTAIN = 10.0  # times what they promise may still be gained, as where a contact is just lost
DAMPING = 1e-3  # with which a fit begins: hardly any
PRIOR_CURVATURE = 1.0  # of the objective by the priors alone; less of it is rounding
STIFFEST = 1e4  # damping at which a step is too small to matter
FARTHEST = 8.0  # a nuisance stays within this many prior standard deviations
TOWARDS_BOUND = (
    0.9  # share of the way to a bound that a step goes at most: an effect of no strength has no slope
)
LEAST_ZERO = 1e-9  # N, standard deviation of the sensor's zero where nothing is said of it
AT_BOUND = 1e-3  # prior standard deviations from a bound, from which on a step may end there


@dataclass(frozen=True)
class Fit:
    """The most probable parameters of one explanation, and the curvature there."""

    observations: Observations
    explanation: Explanation
    coordinates: Coordinates
    u: np.ndarray  # (p,) in prior standard deviations
    nuisance: np.ndarray  # (trials, q) nuisances in prior standard deviations
    objective: float  # half chi-square of data and priors
    chi2: np.ndarray  # (trials,) chi-square of each trial's samples and nuisances
    hessian: np.ndarray  # (p, p) of the objective in u, nuisances eliminated, prior included
    misfit: float  # chi-square of a sample, at least 1: by how much more than noise the variances are
    log_det_nuisances: np.ndarray  # (trials,) of the inverse curvature in the nuisances
    grid: Grid

    @property
    def program(self) -> Explanation:
        """The explanation whose compiled code the fit used: its own, or one with more effects."""
        return self.grid.program or self.explanation

    @property
    def theta(self) -> np.ndarray:
        """The parameters in SI units."""
        return self.coordinates.value(self.u)

    @property
    def physical(self) -> np.ndarray:
        """The parameters of rig and effects, SI units."""
        return self.theta[: len(parameters(self.explanation))]

    @property
    def common(self) -> np.ndarray:
        """What all trials share: the sensor's zero, N, the triggers' delay, s, a measured motion's, waves."""
        return self.theta[len(parameters(self.explanation)) :]

    @property
    def root(self) -> np.ndarray:
        """(p, p) R with R R' the covariance in u, widened by the misfit that the noise does not explain."""
        curvature, vectors = np.linalg.eigh(self.hessian)
        return np.asarray(vectors * np.sqrt(self.misfit / np.maximum(curvature, PRIOR_CURVATURE)))

    @property
    def covariance(self) -> np.ndarray:
        """(p, p) of the parameters in SI units."""
        root = self.coordinates.jacobian(self.u) @ self.root
        return root @ root.T

    def linearised(self) -> Linearisation:
        """The model about the optimum, made anew at each call: all fits of a thousand traces would hold gigabytes."""
        return linearise(
            self.observations, self.explanation, self.coordinates, self.u, self.nuisance, self.grid
        )

    def as_commanded(self) -> np.ndarray:
        """(trials, n) N, the force at the commanded conditions, each trial shifted to where it fits."""
        shifted = np.zeros_like(self.nuisance)
        shifted[:, TIMING] = self.nuisance[:, TIMING]
        return predict(self.observations, self.explanation, self.theta, shifted, self.grid)

    @property
    def at_bound(self) -> np.ndarray:
        """(p,) whether a parameter ended at its bound; all of another one, as is expected, is none."""
        at = self.coordinates
        return (self.u <= at.low + 1e-9) | (self.u >= at.high - 1e-9) & ~at.is_part


def grid_for(
    observations: Observations, explanation: Explanation, program: Explanation | None = None
) -> Grid:
    """A grid fine enough for the rig and for a sensor with dynamics, and long enough for every trial.

    `program`: of `Grid`.
    """
    prior, low_pass = observations.prior, observations.low_pass
    interval = observations.intervals.min(initial=np.inf)
    end = float(observations.ends.max())
    sampled = _stride(explanation) * interval
    if low_pass:
        sampled = min(sampled, RESOLVED / low_pass.cutoff_hz)
    longest = min([sampled, *(cls.longest_step for cls in classes(explanation))])
    h = max(min(step_for(*prior.values), longest), end / (SAMPLES - BEYOND - 2))
    steps = steps_of(observations, h)
    return Grid(
        h,
        int(steps.max()),
        low_pass=low_pass,
        tool_mass=observations.tool_mass,
        program=program,
        block=block_for(steps),
    )


def _stride(explanation: Explanation) -> float:
    """The longest step, in sampling intervals."""
    if delays(explanation):
        return LAGGING  # contact begins anywhere between two samples, and what is followed then is a jump
    return RINGING if any(cls.n_memory for cls in classes(explanation)) else STRIDE


def after_a_step(fitted: Fit, about: Linearisation, trials: np.ndarray) -> float:
    """Chi-square of some trials, given by index, and of the priors after one more step of a fit, to first order.

    `about`: the model about the fit.
    """
    linear, nuisance = about.of(trials), fitted.nuisance[trials]
    return 2 * half_chi_square(linear, fitted.u, nuisance) - normal_equations(linear, fitted.u, nuisance).gain


def _bounded_step(
    hessian: np.ndarray, gradient: np.ndarray, u: np.ndarray, at: Coordinates, damping: float
) -> np.ndarray:
    """The damped Gauss-Newton step with parameters held at bounds that they press against."""
    free = np.ones(len(u), bool)
    step = np.zeros_like(u)
    for _ in range(len(u) + 1):
        step[:] = 0.0
        index = np.flatnonzero(free)
        if not index.size:
            break
        block = hessian[np.ix_(index, index)]
        step[index] = -np.linalg.solve(block + damping * np.diag(np.diag(block)), gradient[index])
        target = u + step
        pressing = free & (((u <= at.low) & (step < 0)) | ((u >= at.high) & (step > 0)))
        if not pressing.any():
            return np.clip(target, *_within_reach(u, at)) - u
        free &= ~pressing
    return step


def _within_reach(u: np.ndarray, at: Coordinates) -> tuple[np.ndarray, np.ndarray]:
    """How far one step may go, down and up."""
    below, above = u - at.low, at.high - u
    return (
        np.where(below > AT_BOUND, u - TOWARDS_BOUND * below, at.low),
        np.where(above > AT_BOUND, u + TOWARDS_BOUND * above, at.high),
    )


def fit(
    observations: Observations,
    explanation: Explanation,
    start: np.ndarray,
    nuisance: np.ndarray | None = None,
    warm: bool = False,
    iterations: int = ITERATIONS,
    tolerance: float = TOLERANCE,
    program: Explanation | None = None,
) -> Fit:
    """The most probable parameters from one start.

    **Arguments:** `start`: (p,) values in SI units, what all trials share last (`begin`). `nuisance`: (trials, q)
    first guess of the nuisances. Those of rings may be missing, and waves in both. `warm`: the start is near the
    optimum already. `program`: an explanation with more effects, whose compiled code is used.

    While the model is far from the data, the noise is taken as large as the misfit: the priors keep the rig where it
    is known to be, and the effect has to explain the data rather than the rig.

    **Returns:** a `Fit`; stops after an iteration that gains less than the share `tolerance` of the objective, and
    promised far less, or two that gain less.
    """
    interval = float(np.median(observations.intervals)) if observations.intervals.size else NO_TIME
    waves = np.ones(observations.n_shared)
    delay = np.ones(observations.n_common - COMMON)  # of a measured motion, in units of its own
    common_std = max(observations.noise.offset_std, LEAST_ZERO), COMMON_TRIGGER * interval, *delay, *waves
    at = coordinates(observations.prior, explanation, common_std)
    known = min(len(start), len(at.centre))
    begin = np.concatenate([start[:known], np.zeros(len(at.centre) - known)])
    u = np.clip(at.coordinate(begin), at.low, at.high)
    guess = np.zeros((len(observations.names), observations.n_nuisances))
    if nuisance is not None:
        known = min(nuisance.shape[1], guess.shape[1])  # other rings may have been found meanwhile
        guess[:, :known] = nuisance[:, :known]
    nuisance = guess
    grid = grid_for(observations, explanation, program)
    key = unfinished.key_of(
        observations.digest, explanation, at, u, nuisance, warm, iterations, tolerance, program
    )
    if found := unfinished.find(key):
        u, nuisance = found
        linear = linearise(observations, explanation, at, u, nuisance, grid)
    else:
        u, nuisance, linear = _optimum(
            observations, explanation, at, u, nuisance, grid, warm, iterations, tolerance
        )
        unfinished.keep(key, u, nuisance)
    objective = half_chi_square(linear, u, nuisance)
    hessian, log_det = np.eye(len(u)), np.zeros(len(nuisance))
    if np.isfinite(objective):
        normal = normal_equations(linear, u, nuisance)
        hessian, log_det = normal.hessian, np.linalg.slogdet(normal.nuisance_inverse)[1]
    with np.errstate(over="ignore"):  # of an unstable integration
        of_trials = (linear.residual**2).sum(1)
        misfit = max(1.0, float(of_trials.sum()) / max(observations.n_used, 1))
    chi2 = of_trials + (nuisance**2).sum(1)
    return Fit(observations, explanation, at, u, nuisance, objective, chi2, hessian, misfit, log_det, grid)


def _optimum(
    observations: Observations,
    explanation: Explanation,
    at: Coordinates,
    u: np.ndarray,
    nuisance: np.ndarray,
    grid: Grid,
    warm: bool,
    iterations: int,
    tolerance: float,
) -> tuple[np.ndarray, np.ndarray, Linearisation]:
    """Where a fit ends that begins at u and nuisance, and the model about it; arguments as of `fit`."""
    grid = grid._replace(pull=0.0 if warm else 1.0)
    linear = linearise(observations, explanation, at, u, nuisance, grid)
    inflation = 1.0 if warm else _inflation(linear, observations.n_used)
    damping, small = DAMPING, 0
    if not np.isfinite(half_chi_square(linear, u, nuisance)):
        iterations = 0  # the simulation breaks down at the start: another start has to do
    for _ in range(iterations):
        value = half_chi_square(linear, u, nuisance, inflation)
        normal = normal_equations(linear, u, nuisance, inflation)
        while damping < STIFFEST:
            step = _bounded_step(normal.hessian, normal.gradient, u, at, damping)
            nuisance_gradient = normal.nuisance_gradient + np.einsum("p,ipa->ia", step, normal.cross)
            nuisance_new = np.clip(
                nuisance - np.einsum("iab,ib->ia", normal.nuisance_inverse, nuisance_gradient),
                -FARTHEST,
                FARTHEST,
            )
            linear_new = linearise(observations, explanation, at, u + step, nuisance_new, grid)
            gain = value - half_chi_square(linear_new, u + step, nuisance_new, inflation)
            if gain > -1e-9:
                break
            damping *= 8
        else:
            break
        expected = normal.expected(step) if damping <= DAMPING else np.inf
        u, nuisance, linear, damping = u + step, nuisance_new, linear_new, max(damping / 5, 1e-8)
        calmer = min(inflation, _inflation(linear, observations.n_used))
        coarse = min(COARSEST, max(1.0, 2 * value * inflation / observations.n_used) ** 2)
        little = tolerance * coarse * max(1.0, value)
        if gain >= little:
            small = 0
        elif CERTAIN * expected < little:
            small = ENOUGH
        else:
            small += 1
        if small >= ENOUGH:
            if inflation == 1.0 and grid.pull == 0.0:
                break
            # what is left is not noise: end with the data at full weight and a contact that lets go
            calmer, small, grid = 1.0, 0, grid._replace(pull=0.0)
            linear = linearise(observations, explanation, at, u, nuisance, grid)
        inflation = calmer
    if grid.pull:
        linear = linearise(observations, explanation, at, u, nuisance, grid._replace(pull=0.0))
    return u, nuisance, linear


def _inflation(linear: Linearisation, samples: int) -> float:
    """Chi-square per sample where it exceeds one: the noise that would explain what the model does not yet."""
    with np.errstate(over="ignore"):  # of an unstable integration
        value = float((linear.residual**2).sum()) / samples
    return max(1.0, value) if np.isfinite(value) else 1e12

"""The fits of `diagnose` by SciPy: `least_squares` over `solve_ivp`, to the same residuals under the same priors.

Parameters, nuisances, bounds, starts and the stopping tolerance are those of `acf_jax.diagnosis`; equations, solver
and derivatives are SciPy's or written here. The Jacobian is a forward difference, and SciPy is given the structure of
the problem: a nuisance acts on its own trial only, so one difference serves all trials.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from acf_jax.inference.fit import FARTHEST, LEAST_ZERO
from acf_jax.inference.observations import COMMON_TRIGGER, N_NUISANCE, TRIGGER, Observations
from acf_jax.inference.parameters import COMMON, Explanation, begin, coordinates, starts

STEP = 1e-2  # of a difference, in prior standard deviations
FTOL = 1e-5  # as `acf_jax.inference.fit.fit` stops
RTOL, ATOL = 1e-6, 1e-9  # forces then err by about 1e-3 N, the noise is 1 N
FASTEST_LAG = 1e-5  # s, a tenth of the sampling interval: a faster sensor reads the force itself

Array = np.ndarray
Simulate = Callable[[Explanation, Array, Array, Array, Sequence[Array]], list[Array]]


class Answer(NamedTuple):
    """Where a fit ended."""

    objective: float  # half chi-square of data, nuisances and priors
    u: Array  # (p,) in prior standard deviations
    simulations: int  # impacts simulated


def rates(explanation: Explanation, t: float, z: Array, theta: Array, v_e: Array, f_p: Array) -> list[Array]:
    """d/dt of flange, speed and the effect's two states, each of shape (impacts,)."""
    m, d, k_f, k_c, *parameters = theta
    x, x_dot, *y = z
    robot = y[0] if explanation == ("robot_compliance",) else 0.0
    f_c = np.maximum(k_c * (v_e * t + robot - x) + f_p, 0.0)
    force: Array = f_c - d * x_dot - k_f * x
    extra: list[Array] = []
    if explanation == ("coulomb_friction",):
        f_0, mu, v_s = parameters
        force = force - (f_0 + mu * f_p) * np.tanh(x_dot / v_s)
    elif explanation == ("robot_compliance",):
        inverse_mass, hz, zeta = parameters
        omega = 2 * np.pi * hz
        extra = [y[1], -inverse_mass * f_c - 2 * zeta * omega * y[1] - omega**2 * y[0]]
    elif explanation == ("sensor_lag",):
        tau, zeta = np.maximum(parameters[0], FASTEST_LAG), parameters[1]
        extra = [y[1], ((f_c - y[0]) / tau - 2 * zeta * y[1]) / tau]
    return [x_dot, force / m, *extra]


def reading(explanation: Explanation, t: Array, z: Array, theta: Array, v_e: Array, f_p: Array) -> Array:
    """Sensed force at the times t, N; before 0 the contact's law goes on, as a late trigger asks for."""
    if explanation == ("sensor_lag",):
        return z[2]
    robot = z[2] if explanation == ("robot_compliance",) else 0.0
    return np.maximum(theta[3] * (v_e * t + robot - z[0]) + f_p, 0.0)


def states(explanation: Explanation) -> int:
    """How many states one impact has."""
    return 4 if explanation in (("robot_compliance",), ("sensor_lag",)) else 2


def one_by_one(
    explanation: Explanation, theta: Array, v_e: Array, f_p: Array, times: Sequence[Array]
) -> list[Array]:
    """A `solve_ivp` an impact; theta (p, impacts), v_e and f_p (impacts,), times of each impact.

    LSODA is the fastest of SciPy's methods here, and copes with a sensor that is much faster than the impact.
    """
    forces = []
    for i, t in enumerate(times):
        trial = theta[:, i], v_e[i], f_p[i]
        solved = solve_ivp(
            lambda s, z, trial=trial: rates(explanation, s, z, *trial),
            (0.0, t[-1]), np.zeros(states(explanation)), method="LSODA", dense_output=True, rtol=RTOL, atol=ATOL,
        )  # fmt: skip
        forces.append(reading(explanation, t, solved.sol(np.maximum(t, 0.0)), *trial))
    return forces


def all_at_once(
    explanation: Explanation, theta: Array, v_e: Array, f_p: Array, times: Sequence[Array]
) -> list[Array]:
    """One `solve_ivp` for all impacts, their states side by side in NumPy arrays; RK45 is the fastest here.

    Its error is a mean over all impacts, in which that of one at its loss of contact would drown: the tolerances are
    as much smaller as one impact can hide.
    """
    count, n = states(explanation), len(v_e)
    tolerances = {"rtol": RTOL / np.sqrt(n), "atol": ATOL / np.sqrt(n)}
    solved = solve_ivp(
        lambda s, z: np.concatenate(rates(explanation, s, z.reshape(count, n), theta, v_e, f_p)),
        (0.0, max(t[-1] for t in times)), np.zeros(count * n), method="RK45", dense_output=True, **tolerances,
    )  # fmt: skip
    forces = []
    for i, t in enumerate(times):
        z = solved.sol(np.maximum(t, 0.0)).reshape(count, n, -1)[:, i]
        forces.append(reading(explanation, t, z, theta[:, i], v_e[i], f_p[i]))
    return forces


class Problem:
    """One explanation against all trials, as `least_squares` asks for it: x = (u, nuisances trial by trial)."""

    def __init__(self, observations: Observations, explanation: Explanation, simulate: Simulate):
        o = observations
        trigger = COMMON_TRIGGER * max(float(np.median(o.interval)), 1e-6)
        self.at = coordinates(o.prior, explanation, (max(o.noise.offset_std, LEAST_ZERO), trigger))
        self.observations, self.explanation, self.simulate = o, explanation, simulate
        self.counts = o.used.sum(1)
        self.spread = np.column_stack([o.rel_std[0] * o.v_e, o.rel_std[1] * o.f_p, TRIGGER * o.interval])
        self.simulations = 0

    def split(self, x: Array) -> tuple[Array, Array]:
        """u and the nuisances, (trials, 3)."""
        p = len(self.at.centre)
        return x[:p], x[p:].reshape(-1, N_NUISANCE)

    def whitened(self, points: Sequence[Array]) -> list[Array]:
        """Whitened residuals of the samples, one vector a point; all points are simulated in one call."""
        o, thetas, v_e, f_p, times, zeros = self.observations, [], [], [], [], []
        for x in points:
            u, nuisance = self.split(x)
            theta, shift = self.at.value(u), nuisance * self.spread
            thetas.append(np.tile(theta[:-COMMON, None], len(nuisance)))
            v_e.append(o.v_e + shift[:, 0])
            f_p.append(o.f_p + shift[:, 1])
            zero, delay = theta[-COMMON:]
            zeros.append(zero)
            late = shift[:, 2] + delay
            times += [o.time[i, :n] - late[i] for i, n in enumerate(self.counts)]
        self.simulations += len(times)
        forces = iter(
            self.simulate(
                self.explanation, np.concatenate(thetas, 1), np.concatenate(v_e), np.concatenate(f_p), times
            )
        )
        return [self._white([next(forces) + zero for _ in self.counts]) for zero in zeros]

    def _white(self, forces: Sequence[Array]) -> Array:
        """Whitened residuals of the samples, one trial's after the other's."""
        left = self.observations.force[:, None].copy()
        for i, force in enumerate(forces):
            left[i, 0, : len(force)] -= force
        return self.observations.whiten(left)[:, 0][self.observations.used]

    def residuals(self, x: Array) -> Array:
        """Samples first, then the priors of parameters and nuisances."""
        return np.concatenate([*self.whitened([x]), x])

    def jacobian(self, x: Array) -> Array:
        """Forward differences: one a parameter, and one for all trials' nuisances of a kind."""
        p = len(self.at.centre)
        steps = np.full(p + N_NUISANCE, STEP)
        steps[:p] = np.where(x[:p] + STEP > self.at.high, -STEP, STEP)
        moves = np.zeros((p + N_NUISANCE, len(x)))
        moves[np.arange(p), np.arange(p)] = 1
        for k in range(N_NUISANCE):
            moves[p + k, p + k :: N_NUISANCE] = 1
        # in the same call as what moved from it: errors of the integration then cancel
        base, *moved = self.whitened([x, *(x + step * move for step, move in zip(steps, moves, strict=True))])
        slopes = [(samples - base) / step for samples, step in zip(moved, steps, strict=True)]
        trial = np.repeat(np.arange(len(self.counts)), self.counts)
        rows = np.zeros((len(base), len(x)))
        rows[:, :p] = np.transpose(slopes[:p])
        for k in range(N_NUISANCE):
            rows[np.arange(len(base)), p + N_NUISANCE * trial + k] = slopes[p + k]
        return np.concatenate([rows, np.eye(len(x))])

    def solve(self, start: Array) -> Answer:
        """Fit from one start, in SI units."""
        nuisance = np.zeros(N_NUISANCE * len(self.counts))
        low = np.concatenate([self.at.low, nuisance - FARTHEST])
        high = np.concatenate([self.at.high, nuisance + FARTHEST])
        x = np.clip(np.concatenate([self.at.coordinate(start), nuisance]), low, high)
        self.simulations = 0
        found = least_squares(self.residuals, x, self.jacobian, (low, high), method="trf", ftol=FTOL)
        return Answer(float(found.cost), self.split(found.x)[0], self.simulations)


def fit(observations: Observations, explanation: Explanation, simulate: Simulate) -> Answer:
    """The best of the starts at the rig's prior; `diagnose` adds one at the recalibrated model."""
    problem = Problem(observations, explanation, simulate)
    prior = observations.prior.values
    begins = starts(explanation[0]) if explanation else [[]]
    answers = [problem.solve(begin(prior, start)) for start in begins]
    best = min(answers, key=lambda answer: answer.objective)
    return best._replace(simulations=sum(answer.simulations for answer in answers))

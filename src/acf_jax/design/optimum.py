"""The best feasible point: sequential quadratic programming from many starts, then an exact step to the optimum."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize
from scipy.stats import qmc

from acf_jax.design.boundary import first_failure
from acf_jax.design.exact import sharpened
from acf_jax.design.task import Task, upper_forces, value_and_slope

CORNERS = 16  # at most so many starts are corners of the box
ROUNDING = 1e-12
SAME = 1e-6  # of a range: optima nearer to each other are one


class Optimum(NamedTuple):
    """What the starts found."""

    u: np.ndarray  # (free,) in the unit box, the best; the least loaded point where none is feasible
    is_feasible: bool
    starts: int
    reached: int  # starts that ended at the best goal
    worse: int  # starts that ended at a worse one, or at none
    without_peak: int  # starts that ended where the model knows no peak


def find_optimum(task: Task, factor: float, starts: np.ndarray) -> Optimum:
    """The best of the optima that each start (starts, free) leads to.

    The goal's coordinate is linear and bounds are bounds of the method, so only the limit is nonlinear: SLSQP (Kraft,
    DFVLR-FB 88-28, 1988) with the model's own derivatives, then `_onto_limit`, after which the limit holds in
    floating-point numbers, not to a tolerance. The best point is sharpened by Newton's method.
    """
    if task.coordinate is not None and len(task.free) == 1:
        u = _onto_limit(task, factor, np.zeros(1))
        return Optimum(np.zeros(1) if u is None else u, u is not None, 1, 1, 0, 0)
    least = [_least(task, factor, start) for start in starts]
    if task.coordinate is None:
        ends = least
    else:
        ends = [_along_limit(task, factor, start) for start in (*starts, min(least, key=_load(task, factor)))]
        exact = [_onto_limit(task, factor, u) for u in ends]
        ends = [u for u in exact if u is not None]
    tried = len(starts) + (task.coordinate is not None)
    if not ends:
        return Optimum(min(least, key=_load(task, factor)), False, tried, 0, tried, 0)
    upper, _, exists = upper_forces(task.model, task.point(np.array(ends)), factor)
    score = upper if task.coordinate is None else -np.array(ends)[:, task.coordinate]
    sound = exists & (upper <= task.limit)
    if not sound.any():
        u = ends[int(np.argmin(np.where(exists, upper, np.inf)))]
        return Optimum(u, False, tried, 0, tried, int((~exists).sum()))
    best = np.where(sound, score, np.inf)
    top = int(np.argmin(best))
    scale = task.limit if task.coordinate is None else 1.0
    reached = int((np.abs(best - best[top]) <= SAME * scale).sum())
    u = _sharpened(task, factor, ends[top])
    return Optimum(u, True, tried, reached, tried - reached, int((~exists).sum()))


def _sharpened(task: Task, factor: float, u: np.ndarray) -> np.ndarray:
    """The optimum itself near the best end of a search; the end where that is not better."""
    if task.coordinate is None:
        sharp = sharpened(task, factor, u)
        return sharp if _load(task, factor)(sharp) <= _load(task, factor)(u) else u
    if u[task.coordinate] == 1.0:
        # many points reach the range's end: the least loaded
        return _least(task, factor, u, fixed=task.coordinate)
    onto = _onto_limit(task, factor, sharpened(task, factor, u))
    return u if onto is None or onto[task.coordinate] < u[task.coordinate] else onto


def start_points(free: int, count: int, seed: int) -> np.ndarray:
    """Corners of the unit box, its middle, and a scrambled Sobol sequence: (count, free)."""
    corners = np.array(np.meshgrid(*[[0.0, 1.0]] * free, indexing="ij")).reshape(free, -1).T
    sobol = qmc.Sobol(free, rng=np.random.default_rng(seed)).random(2 ** int(np.ceil(np.log2(count + 1))))
    return np.concatenate([np.full((1, free), 0.5), corners[:CORNERS], sobol])[:count]


def _load(task: Task, factor: float) -> Callable[[np.ndarray], float]:
    return lambda u: upper_forces(task.model, task.point(u[None]), factor)[0][0]


def _least(task: Task, factor: float, start: np.ndarray, fixed: int | None = None) -> np.ndarray:
    """The point of least F + factor sigma near a start; the coordinate `fixed` stays."""
    bounds = [(0.0, 1.0)] * start.size
    if fixed is not None:
        bounds[fixed] = (start[fixed], start[fixed])
    found = minimize(value_and_slope(task, factor), start, jac=True, bounds=bounds, method="L-BFGS-B")
    return _on_bounds(found.x)


def _along_limit(task: Task, factor: float, start: np.ndarray) -> np.ndarray:
    """The point near a start where the goal's coordinate is largest within the limit, to the method's tolerance."""
    load = value_and_slope(task, factor)
    direction = -np.eye(start.size)[task.coordinate]
    found = minimize(
        lambda u: float(direction @ u),
        start,
        jac=lambda u: direction,
        bounds=[(0.0, 1.0)] * start.size,
        constraints={
            "type": "ineq",
            "fun": lambda u: 1 - load(u)[0],
            "jac": lambda u: -load(u)[1],
        },
        method="SLSQP",
        options={"maxiter": 100, "ftol": 1e-12},
    )
    return _on_bounds(found.x)


def _on_bounds(u: np.ndarray) -> np.ndarray:
    """u within the box; what is a rounding error away from a bound is on it."""
    u = np.clip(u, 0.0, 1.0)
    return np.where(u < ROUNDING, 0.0, np.where(u > 1 - ROUNDING, 1.0, u))


def _onto_limit(task: Task, factor: float, u: np.ndarray) -> np.ndarray | None:
    """The farthest allowed point along the goal's coordinate, the other coordinates as they are."""
    axis = task.coordinate
    assert axis is not None

    def holds(shares: np.ndarray) -> np.ndarray:
        line = np.tile(u, (len(shares), 1))
        line[:, axis] = shares
        upper, _, exists = upper_forces(task.model, task.point(line), factor)
        return exists & (upper <= task.limit)

    found = first_failure(holds)
    if found is None:
        return None
    u = u.copy()
    u[axis] = found.last_held
    return u

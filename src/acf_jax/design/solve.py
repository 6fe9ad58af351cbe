"""A design: the optimum under the stated probability, what its newtons are spent on, and what speaks for it."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from scipy.stats import norm, qmc

from acf_jax.contact.body import WALL
from acf_jax.contact.model import draw_forces, spread
from acf_jax.design.exact import conditions
from acf_jax.design.optimum import Optimum, find_optimum, start_points
from acf_jax.design.remedy import Infeasible, explain
from acf_jax.design.task import Task, upper_forces

ROUNDS = 6
SCAN = 64  # programs of the last scan over the box
TO_SPARE = 2.0  # standard errors of the drawn probability by which the stated one is exceeded


class Sensitivity(NamedTuple):
    """What one quantity does to the peak force at the optimum."""

    name: str
    unit: str
    value: float
    std: float
    slope: float  # N per unit
    per_percent: float  # N that one percent of the value costs
    margin: float  # N of the margin that its uncertainty costs


class Design(NamedTuple):
    """The best point and the evidence for it."""

    task: Task
    z: np.ndarray  # (p,)
    force: float  # N, best estimate
    upper: float  # N, F + factor sigma, at most the limit
    std: float  # N
    factor: float  # so that the stated probability holds among draws
    probability: float  # share of fresh draws within the limit
    draws: int
    goal_per_newton: float | None  # what one more newton of limit is worth in units of the goal
    at_limit: bool
    slack: float  # N, what of the limit is left; never negative
    residual: (
        float | None
    )  # of the conditions for an optimum; None where the model's peak ends before the limit
    at_bounds: tuple[str, ...]
    sensitivities: tuple[Sensitivity, ...]  # most newtons of margin first
    search: Optimum
    scanned: int  # further points spread over the box
    better: int  # of those, allowed and better than the optimum: none, or the search failed
    notes: tuple[str, ...]


def design(task: Task, starts: int = 32, draws: int = 8192, seed: int = 0) -> Design | Infeasible:
    """The best point whose limit holds with the stated probability.

    max goal(z)  subject to  F(z) + factor sigma(z) <= limit,  low <= z <= high

    The first-order quantile F + factor sigma has exact derivatives; its factor is set so that among `draws` draws of
    everything uncertain the limit holds with the probability stated, two standard errors to spare. Search and draws
    alternate until the factor rests, as in sequential optimisation and reliability assessment (Du and Chen, J.
    Mech. Des. 126, 2004, 225).

    **Arguments:** `starts`: of the search. `draws`: of the parameters.

    **Returns:** a `Design`, or `Infeasible` with its remedies.
    """
    points = start_points(len(task.free), starts, seed)
    factor = _factor(task, task.point(points[0]), float(norm.ppf(task.probability)), draws, seed)
    found = find_optimum(task, factor, points)
    if not found.is_feasible:
        return _infeasible(task, found, factor, draws, seed)
    best = found
    for _ in range(ROUNDS):
        z = task.point(best.u)
        new = _factor(task, z, factor, draws, seed)
        if abs(new - factor) <= 1e-6 * max(1.0, abs(factor)):
            break
        factor = new
        best = find_optimum(task, factor, best.u[None])
        if not best.is_feasible:
            return _infeasible(task, best, factor, draws, seed)
    return _report(task, best, found, factor, draws, seed)


def _infeasible(task: Task, found: Optimum, factor: float, draws: int, seed: int) -> Infeasible:
    return explain(task, task.point(found.u), factor, draws, seed)


def _factor(task: Task, z: np.ndarray, factor: float, draws: int, seed: int) -> float:
    """The factor with which F + factor sigma is the stated quantile of the drawn forces at z."""
    upper, force, _ = (float(x[0]) for x in upper_forces(task.model, z[None], 1.0))
    std = upper - force
    if std <= 1e-12 * force:
        return factor
    drawn, exists = draw_forces(task.model, z, WALL, draws, seed)
    p = task.probability
    held = min(p + TO_SPARE * np.sqrt(p * (1 - p) / draws), 1 - 1 / draws)
    rank = int(np.ceil(held * draws)) - 1
    quantile = float(np.sort(np.where(exists, drawn, np.inf))[rank])
    # draws without a peak count as broken; where they fill the quantile the first order stands in, and
    # the probability of the report shows it
    return (quantile - force) / std if np.isfinite(quantile) else factor


def _report(task: Task, best: Optimum, search: Optimum, factor: float, draws: int, seed: int) -> Design:
    model, z = task.model, task.point(best.u)
    peak, own = spread(model, jnp.asarray(z), WALL)
    std, force = float(own.std), float(peak.force)
    gradient, shares = np.asarray(own.gradient), np.asarray(own.parameters)
    upper = float(upper_forces(model, z[None], factor)[0][0])
    fresh, exists = draw_forces(model, z, WALL, draws, seed + 1)
    deviations = np.sqrt(np.r_[np.diag(model.main.covariance), 0.0, 0.0] + (model.relative * z) ** 2)
    margin = upper - force
    rows = [
        Sensitivity(name, unit, float(z[i]), float(deviations[i]), float(gradient[i]), float(gradient[i] * z[i] / 100),
                    float(shares[i] / std**2 * margin) if std else 0.0)
        for i, (name, unit) in enumerate(zip(model.names, model.units, strict=True))
    ]  # fmt: skip
    names = [model.names[i] for i in task.free]
    edges = tuple(n for n, u in zip(names, best.u, strict=True) if u in (0.0, 1.0))
    at_limit = upper >= task.limit * (1 - 1e-9)
    met = conditions(task, factor, best.u)
    c = task.coordinate
    is_inner = c is not None and best.u[c] not in (0.0, 1.0)
    price = float(met.multiplier * (task.high - task.low)[c] / task.limit) if is_inner and at_limit else None
    residual = None if is_inner and not at_limit else met.residual
    scanned, better = _scan(task, best, factor, seed)
    return Design(
        task, z, force, upper, std, factor, float((exists & (fresh <= task.limit)).mean()), draws, price, at_limit,
        task.limit - upper, residual, edges,
        tuple(sorted(rows, key=lambda r: -abs(r.margin) - 1e-9 * abs(r.per_percent))), search, scanned, better,
        tuple(f"{fault}: the model extrapolates" for fault in model.is_extrapolated(z)),
    )  # fmt: skip


def _scan(task: Task, best: Optimum, factor: float, seed: int) -> tuple[int, int]:
    """How many points of another Sobol sequence are there, and how many of them are allowed and better."""
    count = SCAN * max(1, task.model.main.peak.block // 64)
    u = qmc.Sobol(len(task.free), rng=np.random.default_rng(seed + 7)).random(count)
    upper, _, exists = upper_forces(task.model, task.point(u), factor)
    allowed = exists & (upper <= task.limit)
    if task.coordinate is None:
        at_best = upper_forces(task.model, task.point(best.u[None]), factor)[0][0]
        is_better = upper < at_best * (1 - 1e-9)
    else:
        is_better = u[:, task.coordinate] > best.u[task.coordinate] + 1e-9
    return count, int((allowed & is_better).sum())

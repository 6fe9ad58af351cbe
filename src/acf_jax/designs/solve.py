"""A design: the optimum under the stated probability, what its newtons are spent on, and what speaks for it."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.stats import norm

from acf_jax.contact.model import ContactModel, Spread
from acf_jax.contact.stop import Stop
from acf_jax.designs.chance import draw, draws_fault, is_kept, least_draws, margin_at
from acf_jax.designs.exact import conditions
from acf_jax.designs.optimum import Optimum, find_optimum, start_points
from acf_jax.designs.remedy import Infeasible, explain
from acf_jax.designs.stop import needed_stop
from acf_jax.designs.task import Margin, Task, upper_at

ROUNDS = 12
ATTEMPTS = 4  # searches, each with the margin that the fresh draws of the one before ask for
RESTS = 1e-6  # of the margin: less of a change ends the rounds
FORM, EXPLANATIONS = "form of the model", "choice of explanation"


class Sensitivity(NamedTuple):
    """What one quantity, or what the model itself leaves open, does to the peak force at the optimum."""

    name: str
    unit: str | None  # this and the following: None for what is no quantity
    value: float | None
    std: float | None
    slope: float | None  # N per unit
    per_percent: float | None  # N that one percent of the value costs
    margin: float  # N of the margin that its uncertainty costs


class Design(NamedTuple):
    """The best point and the evidence for it."""

    task: Task
    z: np.ndarray  # (p,)
    force: float  # N, best estimate
    upper: float  # N, F + factor sigma, at most the limit
    std: float  # N
    margin: Margin  # with which the stated probability holds among draws
    probability: float  # share of fresh draws within the limit
    draws: int
    goal_per_newton: float | None  # what one more newton of limit is worth in units of the goal
    at_limit: bool
    slack: float  # N, what of the limit is left; never negative
    residual: (
        float | None
    )  # of the conditions for an optimum; None where the model's peak ends before the limit
    sensitivities: tuple[Sensitivity, ...]  # most newtons of margin first
    search: Optimum
    stop: Stop | None  # of the robot, stated or needed; None: no stop is soon enough
    notes: tuple[str, ...]

    @property
    def is_best(self) -> bool:
        """Whether the search has found what a scan of the ranges could."""
        return self.task.is_line or not self.search.better


def design(task: Task, starts: int = 32, draws: int = 8192, seed: int = 0) -> Design | Infeasible:
    """The best point whose limit holds with the stated probability.

    max goal(z)  subject to  P(F(z) <= limit) >= probability,  low <= z <= high

    The first-order quantile F + factor sigma has exact derivatives; its factor is set so that among `draws` draws of
    everything uncertain the limit holds with the probability stated, two standard errors to spare. A draw without a
    peak breaks the limit: where too many do, a peak has to be there within a reach of the best estimate, set likewise.
    Search and draws alternate until both rest, as in sequential optimisation and reliability assessment (Du and Chen,
    J. Mech. Des. 126, 2004, 225). No point is returned whose draws do not hold, fresh ones included: where fresh ones
    contradict, they set the least margin with which the search begins again.

    **Arguments:** `starts`: of the search. `draws`: of the parameters; more are drawn where the probability needs them.

    **Returns:** a `Design`, or `Infeasible` with its remedies, where neither the search nor a scan of the ranges found
    a point.

    **Raises:** `ValueError` for a simulated model with too few draws for the probability.
    """
    if fault := draws_fault(task.model, task.probability, draws):
        raise ValueError(f"draws: {fault}")
    draws = max(draws, least_draws(task.probability))
    points = start_points(len(task.free), starts, seed)
    margin, _ = margin_at(task, task.point(points[0]), Margin(float(norm.ppf(task.probability))), draws, seed)
    least = Margin(-np.inf)
    for attempt in range(ATTEMPTS + 1):
        if attempt < ATTEMPTS:
            found, margin, is_held = _rested(task, margin, least, points, draws, seed)
        else:
            found = _least_loaded(task, margin, points, seed)
            is_held = margin_at(task, task.point(found.u), margin, draws, seed)[1]
        z, fresh_seed = task.point(found.u), seed + 1 + attempt
        fresh = draw(task.model, z, draws, fresh_seed).probability(task.limit)
        if is_held and is_kept(fresh, task.probability, draws):
            return _report(task, found, margin, fresh, draws, seed)
        if not found.is_feasible:
            break
        least = margin = _larger(margin, margin_at(task, z, margin, draws, fresh_seed)[0])
    return explain(task, z, margin, found.scanned, draws, seed)


def _rested(
    task: Task, margin: Margin, least: Margin, points: np.ndarray, draws: int, seed: int
) -> tuple[Optimum, Margin, bool]:
    """Search and draws in turns until both rest: the optimum, its margin, at least `least`, and whether it holds."""
    first, starting = None, points
    for k in range(ROUNDS):
        found = find_optimum(task, margin, starting, seed)
        first = first or (found if found.is_feasible else None)
        new, is_held = margin_at(task, task.point(found.u), margin, draws, seed)
        # two optima may take turns, each the better by the other's margin
        new = _larger(new, margin if k >= ROUNDS // 2 else least)
        if all(abs(a - b) <= RESTS * max(1.0, abs(b)) for a, b in zip(new, margin, strict=True)):
            break
        margin, starting = new, found.u[None] if found.is_feasible else points
    if first is not None:  # later rounds start from the best alone
        found = found._replace(starts=first.starts, reached=first.reached, again=first.again)
    return found, margin, is_held


def _least_loaded(task: Task, margin: Margin, points: np.ndarray, seed: int) -> Optimum:
    """The point of least F + factor sigma, whatever the goal."""
    found = find_optimum(replace(task, goal="widest_margin"), margin, points, seed)
    return found._replace(is_feasible=False)


def _larger(one: Margin, other: Margin) -> Margin:
    return Margin(*map(max, one, other))


def _report(task: Task, found: Optimum, margin: Margin, fresh: float, draws: int, seed: int) -> Design:
    model, z = task.model, task.point(found.u)
    upper, force, _, own = upper_at(model, z, margin)
    at_limit = upper >= task.limit * (1 - 1e-9)
    met = conditions(task, margin.factor, found.u)
    c = task.coordinate
    is_inner = c is not None and found.u[c] not in (0.0, 1.0)
    price = float(met.multiplier * (task.high - task.low)[c] / task.limit) if is_inner and at_limit else None
    residual = None if is_inner and not at_limit else met.residual
    return Design(
        task, z, force, upper, float(own.std), margin, fresh, draws, price, at_limit, task.limit - upper, residual,
        sensitivities(model, z, own, upper - force), found, needed_stop(task, z, draws, seed),
        _notes(task, z, found),
    )  # fmt: skip


def sensitivities(model: ContactModel, z: np.ndarray, own: Spread, margin: float) -> tuple[Sensitivity, ...]:
    """What the margin is spent on, by each one's share of the variance."""
    newtons = margin / float(own.std) ** 2 if own.std else 0.0  # of margin per N^2 of variance
    gradient, shares = np.asarray(own.gradient), np.asarray(own.parameters)
    deviations = np.sqrt(np.r_[np.diag(model.main.covariance), 0.0, 0.0] + (model.relative * z) ** 2)
    rows = [
        Sensitivity(name, unit, float(z[i]), float(deviations[i]), float(gradient[i]), float(gradient[i] * z[i] / 100),
                    float(shares[i]) * newtons)
        for i, (name, unit) in enumerate(zip(model.names, model.units, strict=True))
    ]  # fmt: skip
    left_open = [
        (FORM, own.form, model.form_error > 0),
        (EXPLANATIONS, own.explanations, len(model.others) > 0),
    ]
    rows += [
        Sensitivity(name, None, None, None, None, None, float(variance) * newtons)
        for name, variance, is_there in left_open
        if is_there
    ]
    return tuple(sorted(rows, key=lambda r: -abs(r.margin) - 1e-9 * abs(r.per_percent or 0.0)))


def _notes(task: Task, z: np.ndarray, found: Optimum) -> tuple[str, ...]:
    """What a reader has to know beside the numbers."""
    notes = task.model.notes(z)
    if not found.is_feasible:
        notes.append("nearer to the limit search and draws do not agree: this is the least loaded point")
    if found.better and not task.is_line:
        notes.append(
            f"{found.better} of the scanned points are allowed and better: the search failed; take more starts"
        )
    elif found.better:
        name = task.model.names[task.free[0]]
        notes.append(f"a higher {name} is allowed again, beyond a stretch that is not")
    return tuple(notes)

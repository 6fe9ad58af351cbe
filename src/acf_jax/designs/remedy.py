"""Why no point is feasible, and what would make one."""

from typing import NamedTuple

import numpy as np

from acf_jax.contact.peak import RIG
from acf_jax.designs.boundary import first_failure
from acf_jax.designs.chance import draw, held_share, is_kept, margin_at
from acf_jax.designs.task import Margin, Task, upper_at, upper_forces

LEAST_LEFT = 0.01  # of a quantity: less of it is no remedy
MOST_GROWN = 10.0  # of a quantity that would have to grow
WITHIN = 1e-6  # of a remedy's value
ROUNDS = 3


class Remedy(NamedTuple):
    """One change that alone makes the least loaded point feasible."""

    name: str
    unit: str
    now: float
    needed: float


class Infeasible(NamedTuple):
    """The least loaded point and what is wrong with it."""

    task: Task
    z: np.ndarray  # (p,) the point of least force within the ranges
    force: float  # N, best estimate there
    upper: float  # N, that holds with the stated probability; infinite where too many draws have no peak
    margin: Margin
    has_peak: bool
    without_peak: float  # share of draws whose force rises without a peak
    probability: float  # that the limit holds there
    scanned: int  # points spread over the ranges; none is allowed
    remedies: tuple[Remedy, ...]


def explain(task: Task, z: np.ndarray, margin: Margin, scanned: int, draws: int, seed: int) -> Infeasible:
    """The least loaded point `z`, with every single change that would do; each keeps the stated probability."""
    _, force, exists, _ = upper_at(task.model, z, Margin(0.0))
    drawn = draw(task.model, z, draws, seed)
    upper = drawn.quantile(held_share(task.probability, draws))
    found = [
        Remedy(name, task.model.units[i], float(z[i]), needed)
        for i, name in enumerate(task.model.names)
        if name in (*RIG, "v_e", "f_p") and (needed := _needed(task, z, i, margin, draws, seed)) is not None
    ]
    if task.limit < upper < np.inf:
        found.insert(0, Remedy("limit", "N", task.limit, upper))
    return Infeasible(
        task,
        z,
        force,
        upper,
        margin,
        exists,
        float(1 - drawn.exists.mean()),
        drawn.probability(task.limit),
        scanned,
        tuple(found),
    )


def _needed(task: Task, z: np.ndarray, entry: int, margin: Margin, draws: int, seed: int) -> float | None:
    """The nearest value of one entry of z with which the limit holds among draws."""
    for _ in range(ROUNDS):  # the margin there is another than here
        needed = _nearest(task, z, entry, margin)
        if needed is None:
            return None
        there = z.copy()
        there[entry] = needed
        margin, is_held = margin_at(task, there, margin, draws, seed)
        if is_held:
            return needed
    share = draw(task.model, there, draws, seed).probability(task.limit)
    return needed if is_kept(share, task.probability, draws) else None


def _nearest(task: Task, z: np.ndarray, entry: int, margin: Margin) -> float | None:
    """The nearest value of one entry of z with which the limit holds by a margin."""
    if z[entry] <= 0:
        return None
    for end in (LEAST_LEFT, MOST_GROWN):
        values = z[entry] * np.array([1.0, end])

        def fails(shares: np.ndarray, values: np.ndarray = values) -> np.ndarray:
            line = np.tile(z, (len(shares), 1))
            line[:, entry] = (1 - shares) * values[0] + shares * values[1]
            upper, _, exists = upper_forces(task.model, line, margin)
            return ~(exists & (upper <= task.limit))

        crossing = first_failure(fails, within=WITHIN)
        if crossing is not None and np.isfinite(crossing.first_failed):
            share = crossing.first_failed
            return float((1 - share) * values[0] + share * values[1])
    return None

"""Why no point is feasible, and what would make one."""

from typing import NamedTuple

import numpy as np

from acf_jax.contact.body import WALL
from acf_jax.contact.model import draw_forces
from acf_jax.contact.peak import RIG
from acf_jax.design.boundary import first_failure
from acf_jax.design.task import Task, upper_forces

LEAST_LEFT = 0.01  # of a quantity: less of it is no remedy
MOST_GROWN = 10.0  # of a quantity that would have to grow


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
    upper: float  # N, that holds with the stated probability
    has_peak: bool
    probability: float  # that the limit holds there
    remedies: tuple[Remedy, ...]


def explain(task: Task, z: np.ndarray, factor: float, draws: int, seed: int) -> Infeasible:
    """The least loaded point `z`, with every single change that would do, found exactly."""
    upper, force, exists = (x[0] for x in upper_forces(task.model, z[None], factor))
    drawn, there = draw_forces(task.model, z, WALL, draws, seed)
    found = [
        Remedy(name, task.model.units[i], float(z[i]), needed)
        for i, name in enumerate(task.model.names)
        if name in (*RIG, "v_e", "f_p") and (needed := _needed(task, z, i, factor)) is not None
    ]
    if np.isfinite(upper) and exists:
        found.insert(0, Remedy("limit", "N", task.limit, float(upper)))
    return Infeasible(
        task,
        z,
        float(force),
        float(upper),
        bool(exists),
        float((there & (drawn <= task.limit)).mean()),
        tuple(found),
    )


def _needed(task: Task, z: np.ndarray, entry: int, factor: float) -> float | None:
    """The nearest value of one entry of z with which the limit holds."""
    if z[entry] <= 0:
        return None
    for end in (LEAST_LEFT, MOST_GROWN):
        values = z[entry] * np.array([1.0, end])

        def fails(shares: np.ndarray, values: np.ndarray = values) -> np.ndarray:
            line = np.tile(z, (len(shares), 1))
            line[:, entry] = (1 - shares) * values[0] + shares * values[1]
            upper, _, exists = upper_forces(task.model, line, factor)
            return ~(exists & (upper <= task.limit))

        crossing = first_failure(fails)
        if crossing is not None and np.isfinite(crossing.first_failed):
            share = crossing.first_failed
            return float((1 - share) * values[0] + share * values[1])
    return None

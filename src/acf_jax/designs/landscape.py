"""The design space as a picture sees it: the force that is not exceeded, over one or two free quantities."""

from typing import NamedTuple

import numpy as np

from acf_jax.designs.remedy import Infeasible
from acf_jax.designs.solve import Design
from acf_jax.designs.task import upper_forces

PREFERRED = ("v_e", "f_p")  # axes where they are free


class Landscape(NamedTuple):
    """Force over a line or a plane through the optimum; NaN where the model knows no peak within reach."""

    names: tuple[str, ...]  # of one or two axes
    units: tuple[str, ...]
    axes: tuple[np.ndarray, ...]
    upper: np.ndarray  # N, F + factor sigma, (n,) or (n_y, n_x)
    force: np.ndarray  # N, best estimate
    point: tuple[float, ...]  # the optimum; where nothing is feasible the least loaded point


def landscape(found: Design | Infeasible, points: int = 33) -> Landscape:
    """Forces over the first two free quantities, the others as at the point that was found."""
    task, names = found.task, found.task.model.names
    free = sorted(range(len(task.free)), key=lambda i: (names[task.free[i]] not in PREFERRED, i))[:2]
    axes = tuple(np.linspace(task.low[i], task.high[i], points) for i in free)
    grid = np.meshgrid(*axes)
    z = np.tile(found.z, (grid[0].size, 1))
    for i, values in zip(free, grid, strict=True):
        z[:, task.free[i]] = values.ravel()
    upper, force, exists = upper_forces(task.model, z, found.margin)
    entries = [task.free[i] for i in free]
    return Landscape(
        tuple(names[e] for e in entries),
        tuple(task.model.units[e] for e in entries),
        axes,
        np.where(exists, upper, np.nan).reshape(grid[0].shape),
        np.where(exists, force, np.nan).reshape(grid[0].shape),
        tuple(float(found.z[e]) for e in entries),
    )

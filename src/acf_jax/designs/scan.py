"""Points spread over the ranges: where no search has been, and where derivatives lead nowhere."""

from typing import NamedTuple

import numpy as np
from scipy.stats import qmc

from acf_jax.designs.task import Margin, Task, upper_forces

LEAST = 256  # points of a scan
FIRST, LAST = 0.25, 1e-5  # half width of a refinement, of the ranges
ROUNDS = 60


class Scan(NamedTuple):
    """Points of the unit box and what the model says of them."""

    u: np.ndarray  # (n, free)
    upper: np.ndarray  # (n,) N, infinite where there is no peak
    score: np.ndarray  # (n,) what the goal makes least, infinite where the limit is not held


def judge(task: Task, margin: Margin, u: np.ndarray) -> Scan:
    """What points u (n, free) are worth."""
    upper, _, exists = upper_forces(task.model, task.point(u), margin)
    upper = np.where(exists, upper, np.inf)
    score = upper if task.coordinate is None else -u[:, task.coordinate]
    return Scan(u, upper, np.where(upper <= task.limit, score, np.inf))


def scan(task: Task, margin: Margin, seed: int) -> Scan:
    """A Sobol sequence over the box: 4,096 points, of a simulated model 256."""
    count = max(LEAST, task.model.main.peak.block)
    return judge(task, margin, sobol(len(task.free), count, seed))


def sobol(free: int, count: int, seed: int) -> np.ndarray:
    """The first `count` points of a scrambled Sobol sequence, (count, free)."""
    return qmc.Sobol(free, rng=np.random.default_rng(seed)).random(2 ** int(np.ceil(np.log2(count))))[:count]


def refined(task: Task, margin: Margin, u: np.ndarray) -> np.ndarray:
    """A better point near an allowed one, among points closer and closer around the best so far.

    For an edge that no derivative shows, as where the model's peak ends.
    """
    cloud = 2 * sobol(u.size, max(16, task.model.main.peak.block // 16), 1) - 1
    width, best = FIRST, judge(task, margin, u[None]).score[0]
    for _ in range(ROUNDS):
        if width < LAST:
            break
        near = judge(task, margin, np.clip(u + width * cloud, 0.0, 1.0))
        i = int(np.argmin(near.score))
        if near.score[i] < best:
            u, best = near.u[i], near.score[i]
        else:
            width /= 2
    return u

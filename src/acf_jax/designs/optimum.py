"""The best feasible point: sequential quadratic programming from many starts, a scan, then an exact step."""

from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from acf_jax.designs.boundary import first_failure
from acf_jax.designs.exact import sharpened
from acf_jax.designs.scan import Scan, judge, refined, scan, sobol
from acf_jax.designs.task import Margin, Task, upper_forces, value_and_slope

CORNERS = 16  # at most so many starts are corners of the box
ROUNDING = 1e-12
SAME = 1e-6  # of a range: optima nearer to each other are one
SCANS = 4  # at most, as long as each finds something better
AGAIN = 4  # points of a scan from which a search starts again
LINE = 257  # points of a line whose low end is not allowed


class Optimum(NamedTuple):
    """What the search found."""

    u: np.ndarray  # (free,) in the unit box, the best; the least loaded point where none is feasible
    is_feasible: bool
    starts: int
    reached: int  # starts that ended at the best goal
    again: int  # starts beyond those, from points of a scan that were better than all ends
    scanned: int  # further points spread over the box
    better: int  # of those, allowed and better than the optimum


def find_optimum(task: Task, margin: Margin, starts: np.ndarray, seed: int = 0) -> Optimum:
    """The best of the optima that each start (starts, free) leads to, held against points all over the box.

    The goal's coordinate is linear and bounds are bounds of the method, so only the limit is nonlinear: SLSQP (Kraft,
    DFVLR-FB 88-28, 1988) with the model's own derivatives, then `_onto_limit`, after which the limit holds in
    floating-point numbers, not to a tolerance. Where a scan knows a better point, or the only ones that are allowed,
    the search starts again from there. The best point is sharpened by Newton's method.

    With the goal's coordinate alone, the answer is the end of the first allowed stretch.
    """
    if task.is_line:
        return _first_stretch(task, margin, seed)
    first = ends = _ends(task, margin, starts)
    again = 0
    for k in range(SCANS):
        seen = scan(task, margin, seed + k)
        is_better = seen.score < _best(ends) - _same(task)
        if not is_better.any():
            break
        top = seen.u[np.argsort(seen.score)[: min(AGAIN, int(is_better.sum()))]]
        ends = _joined(ends, _ends(task, margin, top), judge(task, margin, top))
        ends = _joined(ends, _nearby(task, margin, ends.u[np.argmin(ends.score)]))
        again += len(top)
        is_better = seen.score < _best(ends) - _same(task)
    tried, best = len(first.u), _best(ends)
    if np.isinf(best):
        every = _joined(ends, seen)
        return Optimum(every.u[np.argmin(every.upper)], False, tried, 0, again, len(seen.u), 0)
    u = _sharpened(task, margin, ends.u[np.argmin(ends.score)])
    reached = int((first.score <= best + _same(task)).sum())
    return Optimum(u, True, tried, reached, again, len(seen.u), int(is_better.sum()))


def start_points(free: int, count: int, seed: int) -> np.ndarray:
    """Corners of the unit box, its middle, and a scrambled Sobol sequence: (count, free)."""
    corners = np.array(np.meshgrid(*[[0.0, 1.0]] * free, indexing="ij")).reshape(free, -1).T
    return np.concatenate([np.full((1, free), 0.5), corners[:CORNERS], sobol(free, count + 1, seed)])[:count]


def _first_stretch(task: Task, margin: Margin, seed: int) -> Optimum:
    """The end of the first allowed stretch of a line."""
    line = np.linspace(0.0, 1.0, LINE)[:, None]
    lowest = judge(task, margin, line[:1])
    on_line = lowest if np.isfinite(lowest.score[0]) else judge(task, margin, line)
    u = on_line.u[np.argmax(np.isfinite(on_line.score))]
    end = _onto_limit(task, margin, u)
    if end is None:
        return Optimum(on_line.u[np.argmin(on_line.upper)], False, 1, 0, 0, LINE, 0)
    seen = scan(task, margin, seed)
    return Optimum(end, True, 1, 1, 0, len(seen.u), int((seen.score < -end[0] - 1e-9).sum()))


def _ends(task: Task, margin: Margin, starts: np.ndarray) -> Scan:
    """Where a search from each start ends."""
    least = np.array([_least(task, margin.factor, start) for start in starts])
    if task.coordinate is None:
        return judge(task, margin, least)
    lowest = least[np.argmin(judge(task, margin, least).upper)]
    ends = [_along_limit(task, margin.factor, start) for start in (*starts, lowest)]
    exact = [_onto_limit(task, margin, u) for u in ends]
    return judge(task, margin, np.array([u if e is None else e for u, e in zip(ends, exact, strict=True)]))


def _nearby(task: Task, margin: Margin, u: np.ndarray) -> Scan:
    """What points close to an allowed one lead to."""
    near = refined(task, margin, u)
    onto = None if task.coordinate is None else _onto_limit(task, margin, near)
    return judge(task, margin, (near if onto is None else onto)[None])


def _best(ends: Scan) -> float:
    return float(ends.score.min())


def _joined(*parts: Scan) -> Scan:
    return Scan(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _same(task: Task) -> float:
    """Scores nearer to each other are equal."""
    return SAME * (task.limit if task.coordinate is None else 1.0)


def _sharpened(task: Task, margin: Margin, u: np.ndarray) -> np.ndarray:
    """The optimum itself near the best end of a search; the end where that is not better."""
    if task.coordinate is not None and u[task.coordinate] == 1.0:
        # many points reach the range's end: the least loaded
        other = _least(task, margin.factor, u, fixed=task.coordinate)
    elif task.coordinate is not None and judge(task, margin, u[None]).upper[0] < (1 - SAME) * task.limit:
        return u  # at the peak's end, where the conditions say nothing
    else:
        other = sharpened(task, margin.factor, u)
    onto = other if task.coordinate is None else _onto_limit(task, margin, other)
    if onto is None:
        return u
    both = judge(task, margin, np.stack([onto, u]))
    # at the range's end both score alike, and the first is the one that is loaded less
    return both.u[np.argmin(both.score)]


def _least(task: Task, factor: float, start: np.ndarray, fixed: int | None = None) -> np.ndarray:
    """The point of least F + factor sigma near a start; the coordinate `fixed` stays."""
    bounds = [(0.0, 1.0)] * start.size
    if fixed is not None:
        bounds[fixed] = (start[fixed], start[fixed])
    found = minimize(value_and_slope(task, factor), start, jac=True, bounds=bounds, method="L-BFGS-B")
    return _on_bounds(found.x, start)


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
    return _on_bounds(found.x, start)


def _on_bounds(u: np.ndarray, start: np.ndarray) -> np.ndarray:
    """u within the box; what is a rounding error away from a bound is on it. The start of a search that got lost."""
    if not np.isfinite(u).all():
        return start
    u = np.clip(u, 0.0, 1.0)
    return np.where(u < ROUNDING, 0.0, np.where(u > 1 - ROUNDING, 1.0, u))


def _onto_limit(task: Task, margin: Margin, u: np.ndarray) -> np.ndarray | None:
    """The point of the goal's line through u where what is allowed ends: outwards from an allowed u, else inwards."""
    axis = task.coordinate
    assert axis is not None

    def at(coordinates: np.ndarray) -> np.ndarray:
        line = np.tile(u, (len(coordinates), 1))
        line[:, axis] = coordinates
        return line

    def holds(coordinates: np.ndarray) -> np.ndarray:
        upper, _, exists = upper_forces(task.model, task.point(at(coordinates)), margin)
        return exists & (upper <= task.limit)

    outwards = first_failure(holds, start=float(u[axis]))
    if outwards is not None:
        return at(np.array([outwards.last_held]))[0]
    inwards = first_failure(lambda shares: ~holds(u[axis] * (1 - shares)))
    if inwards is None or not np.isfinite(inwards.first_failed):
        return None
    return at(np.array([u[axis] * (1 - inwards.first_failed)]))[0]

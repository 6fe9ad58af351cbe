"""A design's question in numbers: what is free, within what, for which goal and limit."""

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from acf_jax.contact.body import WALL
from acf_jax.contact.ended import Ended
from acf_jax.contact.model import ContactModel, Spread, root_of, spread
from acf_jax.designs.config import COORDINATE, Goal
from acf_jax.kept import compiled_quickly

DIFFERENCE = 1e-4  # of a range
SHARE_OF_BLOCK = 4  # an upper force needs a peak's derivatives as well: fewer samples a program


class Margin(NamedTuple):
    """How far from the best estimate the limit has to hold."""

    factor: float  # standard deviations of the force: F + factor sigma <= limit
    reach: float = (
        0.0  # standard deviations of everything uncertain, either way, within which there is a peak
    )


@dataclass(frozen=True)
class Task:
    """Find the entries `free` of z, within [low, high], that are best for `goal` with F + factor sigma <= limit."""

    model: ContactModel
    z: np.ndarray  # (p,) every entry; those that are free hold anything
    free: tuple[int, ...]
    low: np.ndarray  # (free,)
    high: np.ndarray
    goal: Goal
    limit: float  # N
    probability: float

    @property
    def coordinate(self) -> int | None:
        """Which free entry the goal makes as large as possible; None for the margin."""
        name = COORDINATE[self.goal]
        return None if name is None else self.free.index(self.model.names.index(name))

    @property
    def is_line(self) -> bool:
        """Whether nothing but the goal's coordinate is free."""
        return self.coordinate is not None and len(self.free) == 1

    @property
    def is_sampled(self) -> bool:
        """Whether the force is the largest sample of a simulation: its second derivatives tell nothing more."""
        peak = self.model.main.peak
        return peak.is_simulated() or isinstance(peak, Ended)

    def point(self, u: np.ndarray) -> np.ndarray:
        """z of points u in the unit box, (..., free)."""
        z = np.broadcast_to(self.z, (*np.shape(u)[:-1], self.z.size)).copy()
        # a convex combination meets both ends exactly
        z[..., list(self.free)] = (1 - u) * self.low + u * self.high
        return z


def make_task(
    model: ContactModel,
    ranges: Mapping[str, tuple[float, float]],
    fixed: Mapping[str, float],
    goal: Goal,
    limit: float,
    probability: float,
) -> Task:
    """The task whose `ranges` are free; `fixed` holds v_e and f_p where they are not.

    **Arguments:** `ranges`: lowest and highest value by name, SI units. `limit`: of the peak contact force, N.
    `probability`: with which it is to hold.

    **Raises:** `ValueError` for a range of what is not one of the model's parameters.
    """
    names = model.names
    z = model.at(fixed.get("v_e", 0.0), fixed.get("f_p", 0.0))
    low, high = (np.array([r[k] for r in ranges.values()], float) for k in (0, 1))
    free = tuple(names.index(name) for name in ranges)
    z[list(free)] = low
    return Task(model, z, free, low, high, goal, limit, probability)


Upper = tuple[np.ndarray, np.ndarray, np.ndarray]  # F + factor sigma, F, whether there is a peak within reach


class _Away(NamedTuple):
    """Points (k, p) beside a sample z: z + fixed + share z."""

    fixed: np.ndarray
    share: np.ndarray


def _away(model: ContactModel, reach: float) -> _Away | None:
    """What everything uncertain about z may do to it, one at a time, either way; None where nothing has to."""
    if reach == 0:
        return None
    fixed = np.pad(root_of(model.main.covariance).T, ((0, 0), (0, 2)))
    share = np.diag(model.relative)[model.relative > 0]
    fixed, share = np.r_[fixed, 0 * share], np.r_[0 * fixed, share]
    return _Away(reach * np.r_[fixed, -fixed], reach * np.r_[share, -share])


@compiled_quickly
def _upper(
    model: ContactModel, z: Float[Array, "n p"], factor: Float[Array, ""], away: _Away | None
) -> tuple[Array, Array, Array, Spread]:
    least = jnp.append(model.main.low, jnp.zeros(2))

    def one(z: Float[Array, " p"]) -> tuple[Array, Array, Array, Spread]:
        peak, own = spread(model, z, WALL, factor)
        exists = peak.exists
        if away is not None:
            beside = jnp.maximum(z[None] + away.fixed + away.share * z[None], least[None])
            exists &= jax.vmap(model.main.peak, (0, None))(beside, WALL).exists.all()
        return peak.force + factor * own.std, peak.force, exists, own

    mapped: tuple[Array, Array, Array, Spread] = jax.vmap(one)(z)
    return mapped


def upper_forces(model: ContactModel, z: np.ndarray, margin: Margin) -> Upper:
    """F + factor sigma, F and whether there is a peak within reach, of many samples z (N, p)."""
    size, parts = _size(model), []
    for start in range(0, len(z), size):
        part = z[start : start + size]
        *found, _ = _padded(model, part, margin)
        parts.append([np.asarray(x)[: len(part)] for x in found])
    joined = [np.concatenate(column) for column in zip(*parts, strict=True)]
    return joined[0], joined[1], joined[2]


def upper_at(model: ContactModel, z: np.ndarray, margin: Margin) -> tuple[float, float, bool, Spread]:
    """The same of one sample z (p,), and where its standard deviation comes from."""
    upper, force, exists, own = jax.tree.map(lambda x: np.asarray(x)[0], _padded(model, z[None], margin))
    return float(upper), float(force), bool(exists), own


def _size(model: ContactModel) -> int:
    return max(1, model.main.peak.block // SHARE_OF_BLOCK)


def _padded(model: ContactModel, z: np.ndarray, margin: Margin) -> tuple[Array, Array, Array, Spread]:
    """Up to `_size` samples by a program that takes so many."""
    padded = jnp.asarray(z[np.arange(_size(model)) % len(z)])
    found: tuple[Array, Array, Array, Spread] = _upper(
        model, padded, jnp.asarray(margin.factor), _away(model, margin.reach)
    )
    return found


def _differences(task: Task, factor: float, u: np.ndarray) -> tuple[float, np.ndarray]:
    """The same by central differences, one-sided at the box's faces."""
    moved = np.clip(
        u + DIFFERENCE * np.concatenate([np.zeros((1, u.size)), np.eye(u.size), -np.eye(u.size)]), 0.0, 1.0
    )
    value, *beside = upper_forces(task.model, task.point(moved), Margin(factor))[0] / task.limit
    up, down = np.split(np.array(beside), 2)
    return float(value), (up - down) / np.diag(moved[1 : u.size + 1] - moved[u.size + 1 :])


@eqx.filter_jit
def _slope(
    model: ContactModel, z: Float[Array, " p"], factor: Float[Array, ""], free: tuple[int, ...]
) -> tuple[Array, Array]:
    def along(x: Float[Array, " free"]) -> tuple[Array, Array]:
        peak, own = spread(model, z.at[jnp.array(free)].set(x), WALL, factor)
        upper = peak.force + factor * own.std
        return upper, upper

    slope, value = jax.jacfwd(along, has_aux=True)(z[jnp.array(free)])
    return value, slope


def value_and_slope(task: Task, factor: float) -> Callable[[np.ndarray], tuple[float, np.ndarray]]:
    """The function u -> (F + factor sigma)/limit and its gradient in the unit box.

    By differences where the force is simulated: second derivatives of a simulation take from many seconds to minutes to
    compile, and its samples leave no more digits.
    """

    @functools.lru_cache(maxsize=2)  # SciPy asks for the value and for the gradient in turn
    def at(key: bytes) -> tuple[float, np.ndarray]:
        u = np.clip(np.frombuffer(key), 0.0, 1.0)
        if task.is_sampled:
            return _differences(task, factor, u)
        z = jnp.asarray(task.point(u))
        value, slope = _slope(task.model, z, jnp.asarray(factor), task.free)
        return float(value) / task.limit, np.asarray(slope) * (task.high - task.low) / task.limit

    return lambda u: at(np.asarray(u, float).tobytes())

"""An optimum to the last digits: Newton's method on the conditions of Karush, Kuhn and Tucker."""

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Array, Bool, Float

from acf_jax.contact.body import WALL
from acf_jax.contact.model import ContactModel, spread
from acf_jax.designs.task import Task, value_and_slope

NEAR = 1e-6  # of a range: a search ends so far from a bound that it runs along
STEPS = 32
TOLERANCE = 1e-13


class Conditions(NamedTuple):
    """What the conditions for an optimum leave at a point of the unit box.

    minimise -u_c  subject to  U(u) = (F + factor sigma)/limit <= 1,  0 <= u <= 1:
    r = lambda grad U - e_c is zero where u is free, not negative at a low bound, not positive at a high one,
    lambda >= 0 and lambda (1 - U) = 0. Without a goal's coordinate U itself is minimised, r = grad U.
    """

    residual: float  # the largest violation; zero at an exact optimum
    multiplier: float  # lambda, shares of the goal's range per share of the limit
    is_free: np.ndarray  # (free,) which entries of u no bound holds


def conditions(task: Task, factor: float, u: np.ndarray) -> Conditions:
    """The conditions at u, by the model's own derivatives."""
    value, slope = value_and_slope(task, factor)(u)
    multiplier, reduced, unused = 0.0, slope.copy(), 0.0
    if (c := task.coordinate) is not None:
        ends, rises = u[c] == 1.0, slope[c] > 0
        multiplier = 0.0 if ends else 1 / slope[c] if rises else np.inf
        reduced = multiplier * slope if rises and not ends else np.zeros_like(slope)
        reduced[c] -= 1.0
        unused = multiplier * abs(1 - value)
    is_low, is_high = (u <= NEAR) & (reduced >= 0), (u >= 1 - NEAR) & (reduced <= 0)
    is_free = ~(is_low | is_high)
    return Conditions(
        float(max(unused, np.abs(reduced[is_free]).max(initial=0.0))), float(multiplier), is_free
    )


def sharpened(task: Task, factor: float, u: np.ndarray) -> np.ndarray:
    """The optimum near u, where a search has ended, with bounds met and the rest solving the conditions.

    **Returns:** u itself where Newton's method does not rest, or rests outside the box, and where the force is
    simulated, whose samples leave nothing to sharpen.
    """
    if task.is_sampled:
        return u
    there = conditions(task, factor, u)
    met = np.where(there.is_free, u, np.round(u))
    free = tuple(np.flatnonzero(there.is_free).tolist())
    if not set(free) - {task.coordinate}:
        return met
    unknowns = np.array([*met[list(free)], there.multiplier])
    found, rests = _solve(_Question(task, factor, met), jnp.asarray(unknowns), free, task.coordinate)
    met[list(free)] = np.asarray(found)[:-1]
    is_inside = ((met >= 0) & (met <= 1)).all()
    return met if bool(rests) and is_inside else u


class _Question(eqx.Module):
    """A task's arrays, so that one compiled program serves all its rounds."""

    model: ContactModel
    z: Float[Array, " p"]
    low: Float[Array, " free"]
    high: Float[Array, " free"]
    limit: Float[Array, ""]
    factor: Float[Array, ""]
    u: Float[Array, " free"]
    entries: tuple[int, ...] = eqx.field(static=True)

    def __init__(self, task: Task, factor: float, u: np.ndarray):
        self.model, self.entries = task.model, task.free
        arrays = map(jnp.asarray, (task.z, task.low, task.high, task.limit, factor, u))
        self.z, self.low, self.high, self.limit, self.factor, self.u = arrays

    def load(self, u: Float[Array, " free"]) -> Float[Array, ""]:
        """U(u)."""
        z = self.z.at[jnp.array(self.entries)].set((1 - u) * self.low + u * self.high)
        peak, own = spread(self.model, z, WALL, self.factor)
        return (peak.force + self.factor * own.std) / self.limit


@eqx.filter_jit
def _solve(
    question: _Question, start: Float[Array, " k+1"], free: tuple[int, ...], goal: int | None
) -> tuple[Float[Array, " k+1"], Bool[Array, ""]]:
    """The free entries of u and lambda that solve the conditions, and whether they do."""
    places = jnp.array(free)

    def left(y: Float[Array, " k+1"], _: None) -> Float[Array, " k+1"]:
        u = question.u.at[places].set(y[:-1])
        value = question.load(u)
        slope = jax.jacfwd(question.load)(u)
        if goal is None:
            return jnp.append(slope[places], y[-1])
        stationary = y[-1] * slope - jnp.zeros_like(u).at[goal].set(1.0)
        return jnp.append(stationary[places], value - 1)

    found: Any = optx.root_find(left, optx.Newton(TOLERANCE, TOLERANCE), start, max_steps=STEPS, throw=False)
    return found.value, jnp.asarray(found.result == optx.RESULTS.successful)

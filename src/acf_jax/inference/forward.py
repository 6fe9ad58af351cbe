"""One compiled program an explanation: forces of all trials and their derivatives in every free parameter."""

import dataclasses
import functools
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from acf_jax.dataset import LowPass
from acf_jax.dataset.low_pass import Filter
from acf_jax.effects import AbstractEffect
from acf_jax.effects._interface import Scalar
from acf_jax.inference.free_curves import CONTINUED
from acf_jax.inference.interpolation import first_loss
from acf_jax.inference.parameters import RIG, Explanation, classes, parameters
from acf_jax.kept import kept
from acf_jax.model import Impact, Rig
from acf_jax.simulator.derivatives import simulate_with_derivatives
from acf_jax.simulator.simulate import System, make_system

STEP_PER_RADIAN = 0.1  # omega h of the grid
SAMPLES = 1024  # length of the grid; only as much of it is computed as the trials need
MADE_OF = (  # what holds all that the program calls
    "effects",
    "inference/forward.py",
    "inference/free_curves",
    "inference/interpolation.py",
    "inference/parameters.py",
    "model",
    "simulator",
)
PROGRAMS = 64  # that stay loaded: each takes 10 to 100 MB, and little time to load again
BLOCK = 24  # trials of one call, the last one padded: data sets of every size share compiled code and memory is bounded


class Grid(NamedTuple):
    """Step and number of steps of the integration, common to all trials."""

    h: float  # s
    steps: int
    pull: float = (
        0.0  # 1 continues the equations beyond the loss of contact, which keeps derivatives alive there
    )
    low_pass: LowPass | None = None  # that readings have been through


def step_for(m: float, d: float, k_f: float, k_c: float) -> float:
    """The longest step, s, of a simulation of a rig: a share of a radian, within the decay of a strong damper."""
    return float(1 / max(np.sqrt((k_f + k_c) / m) / STEP_PER_RADIAN, d / m))


class Forces(NamedTuple):
    """Forces of every trial on the grid, with derivatives of the sensed one, which a low-pass has been through."""

    contact: np.ndarray  # (trials, steps + 1), N
    rows: np.ndarray  # (trials, p + 3, steps + 1): sensed force in N, then its tangents

    @property
    def sensed(self) -> np.ndarray:
        """(trials, steps + 1), N."""
        return self.rows[:, 0]

    @property
    def tangents(self) -> np.ndarray:
        """(trials, p + 2, steps + 1), N per unit of each parameter, of v_E and of F_P."""
        return self.rows[:, 1:]


def unpack(
    explanation: Explanation, theta: Float[Array, " p"], reach: Scalar | float = np.inf
) -> tuple[Rig, list[AbstractEffect]]:
    """Rig and effects from the vector of an explanation's parameters, SI units.

    `reach`: the contact force, N, up to which a free curve of it was tried.
    """
    effects, k = [], len(RIG)
    for cls in classes(explanation):
        n = len(cls.parameters())
        effect = cls(*theta[k : k + n])
        if isinstance(effect, CONTINUED):
            effect = dataclasses.replace(effect, reach=jnp.asarray(reach))
        effects.append(effect)
        k += n
    return Rig(*theta[: len(RIG)]), effects


@functools.lru_cache(PROGRAMS)
def _program(explanation: Explanation) -> Callable[..., tuple[Array, Array]]:
    def system(z: Float[Array, " p+2"], pull: Scalar, reach: Scalar) -> System:
        rig, effects = unpack(explanation, z[:-2], reach)
        return make_system(rig, Impact(z[-2], z[-1]), effects, pull)

    def program(
        z: Float[Array, "trials p+2"], h: Scalar, steps: Int[Array, ""], pull: Scalar, reach: Scalar
    ) -> tuple[Float[Array, "samples trials"], Float[Array, "samples p+3 trials"]]:
        return simulate_with_derivatives(partial(system, pull=pull, reach=reach), z, h, SAMPLES, steps)

    number = jax.ShapeDtypeStruct((), float)
    z = jax.ShapeDtypeStruct((BLOCK, len(parameters(explanation)) + 2), float)
    steps = jax.ShapeDtypeStruct((), int)
    return kept(program, f"forward {explanation}", (z, number, steps, number, number), MADE_OF)


def reach_of(
    explanation: Explanation, theta: np.ndarray, v_e: np.ndarray, f_p: np.ndarray, grid: Grid
) -> float:
    """The contact force, N, up to which impacts try a free curve of it; infinite without one."""
    if not any(issubclass(cls, CONTINUED) for cls in classes(explanation)):
        return np.inf
    contact = forward(explanation, theta, v_e, f_p, grid).contact
    # when contact was lost, a free curve may go anywhere
    in_contact = np.arange(contact.shape[1]) < first_loss(contact)[:, None]
    return float(contact[in_contact].max())


def forward(
    explanation: Explanation,
    theta: np.ndarray,
    v_e: np.ndarray,
    f_p: np.ndarray,
    grid: Grid,
    reach: float = np.inf,
) -> Forces:
    """Forces of all trials and their derivatives.

    **Arguments:** `theta`: (p,) the explanation's parameters, SI units. `v_e`, `f_p`: (trials,), m/s and N. `reach`: of
    `reach_of`, where a free curve is continued beyond the trials that it was fitted to.

    **Returns:** `Forces`; not finite where the integration is unstable.
    """
    n, used = len(v_e), grid.steps + 1
    z = np.column_stack([np.tile(theta, (n, 1)), v_e, f_p])
    contact, rows = np.empty((n, used)), np.empty((n, z.shape[1] + 1, used))
    for first in range(0, n, BLOCK):
        here = slice(first, min(first + BLOCK, n))
        padded = z[here][np.arange(BLOCK) % (here.stop - first)]
        found = _program(explanation)(padded, grid.h, grid.steps, grid.pull, reach)
        # turned here, where most of the grid is left out already
        contact[here] = np.asarray(found[0])[:used, : here.stop - first].T
        rows[here] = np.asarray(found[1])[:used, :, : here.stop - first].transpose(2, 1, 0)
    if grid.low_pass:  # linear: it does to derivatives what it does to forces
        rows[:, :, 0] /= (
            2  # the step at first contact is at time 0, not in the middle of the interval before it
        )
        rows = Filter(grid.low_pass, grid.h)(rows)
    return Forces(contact, rows)

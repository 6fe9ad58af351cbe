"""Forces of all trials: one compiled program an explanation with derivatives in every free parameter, one for all laws
without."""

import dataclasses
import functools
import threading
from collections.abc import Callable, Hashable
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from acf_jax import effects
from acf_jax.dataset import LowPass
from acf_jax.dataset.low_pass import Filter
from acf_jax.effects import AbstractEffect
from acf_jax.effects._interface import Scalar
from acf_jax.inference.free_curves import CONTINUED
from acf_jax.inference.interpolation import first_loss
from acf_jax.inference.parameters import RIG, Explanation, classes, neutral, parameters, places, split
from acf_jax.inference.robot_motion import ERRORS, NODES, MeasuredMotion, RobotMotion
from acf_jax.kept import kept
from acf_jax.model import Impact, Rig
from acf_jax.simulator.derivatives import simulate_with_derivatives
from acf_jax.simulator.simulate import Response, System, make_system, simulate

STEP_PER_RADIAN = 0.1  # omega h of the grid
SAMPLES = 1024  # length of the grid; only as much of it is computed as the trials need
MADE_OF = (  # what holds all that the program calls
    "effects",
    "inference/forward.py",
    "inference/free_curves",
    "inference/interpolation.py",
    "inference/parameters.py",
    "inference/robot_motion.py",
    "model",
    "simulator",
)
PROGRAMS = 64  # that stay loaded: each takes 10 to 100 MB, and little time to load again
# trials of one call, the last one padded: data sets of every size share compiled code, and memory is bounded
BLOCKS = (24, 16, 8)
STEP = 12  # a step of a call takes as long as it does for so many trials more; of pairs of laws


class Grid(NamedTuple):
    """Step and number of steps of the integration, common to all trials."""

    h: float  # s
    steps: int
    pull: float = (
        0.0  # 1 continues the equations beyond the loss of contact, which keeps derivatives alive there
    )
    low_pass: LowPass | None = None  # that readings have been through
    tool_mass: float | None = None  # kg, of the moving mass, between contact and sensor
    # with more effects, which is compiled already: without strength these change nothing
    program: Explanation | None = None
    block: int = BLOCKS[0]  # trials of one call


def step_for(m: float, d: float, k_f: float, k_c: float) -> float:
    """The longest step, s, of a simulation of a rig: a share of a radian, within the decay of a strong damper."""
    return float(1 / max(np.sqrt((k_f + k_c) / m) / STEP_PER_RADIAN, d / m))


def block_for(steps: np.ndarray) -> int:
    """Trials of one call with which those that need so many `steps` (trials,) each are simulated soonest.

    All of one call take as many as the longest of them.
    """

    def spent(block: int) -> int:
        return sum(int(steps[part].max()) for part in _blocks(steps, block)) * (STEP + block)

    return min(BLOCKS, key=spent)


def _blocks(steps: np.ndarray, block: int) -> list[np.ndarray]:
    """Trials of one call each, by index, the longest together."""
    order = np.argsort(-steps, kind="stable")
    return [order[first : first + block] for first in range(0, len(order), block)]


class Forces(NamedTuple):
    """Forces of every trial on the grid, with derivatives of the sensed one, which a low-pass has been through."""

    contact: np.ndarray  # (trials, steps + 1), N
    rows: np.ndarray  # (trials, p + q + 3, steps + 1): sensed force in N, then its tangents

    @property
    def sensed(self) -> np.ndarray:
        """(trials, steps + 1), N."""
        return self.rows[:, 0]

    @property
    def tangents(self) -> np.ndarray:
        """(trials, p + 2 + q, steps + 1), N per unit of each parameter, of v_E, of F_P and of a motion's q errors."""
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


def system_of(
    explanation: Explanation,
    z: Float[Array, " p+2+q"],
    *moves: Float[Array, "parts nodes"],
    pull: Scalar | float = 0.0,
    reach: Scalar | float = np.inf,
    spacing: Scalar | float | None = None,
    tool_mass: Scalar | float | None = None,
) -> System:
    """The equations of one trial.

    **Arguments:** `z`: the explanation's parameters, v_E, F_P and, of a robot that moves as measured, the `q` errors of
    that; `moves` are then velocity and displacement of `MeasuredMotion`, at nodes so many s apart as `spacing` says.
    """
    return make_system(*_acting(explanation, z, *moves, reach=reach, spacing=spacing), pull, tool_mass)


def _acting(
    explanation: Explanation,
    z: Float[Array, " p+2+q"],
    *moves: Float[Array, "parts nodes"],
    reach: Scalar | float = np.inf,
    spacing: Scalar | float | None = None,
) -> tuple[Rig, Impact, list[AbstractEffect]]:
    p = len(parameters(explanation))
    rig, acting = unpack(explanation, z[:p], reach)
    if spacing is not None:
        weight = jnp.concatenate([jnp.ones(1), z[p + 2 :]])
        velocity, displacement = moves
        acting.append(MeasuredMotion(spacing, velocity, displacement, weight))
    return rig, Impact(z[p], z[p + 1]), acting


@functools.lru_cache(PROGRAMS)
def _making(*key: Hashable) -> threading.Lock:
    """Held while a program is made, which several threads may ask for at once."""
    return threading.Lock()


def _program(
    explanation: Explanation, is_moved: bool, has_tool: bool, block: int, is_plain: bool = False
) -> Callable[..., tuple[Array, Array]]:
    """The program of `_made`, which one thread makes if several ask for it at once."""
    key = explanation, is_moved, has_tool, block, is_plain
    with _making(*key):
        return _made(*key)


@functools.lru_cache(PROGRAMS)
def _made(
    explanation: Explanation, is_moved: bool, has_tool: bool, block: int, is_plain: bool
) -> Callable[..., tuple[Array, Array]]:
    """Of so many impacts as a `block` has; `is_moved`: whose robots move as measured; `has_tool`: before the sensor.

    `is_plain`: without derivatives.
    """

    def program(
        z: Float[Array, "trials p+2+q"],
        h: Scalar,
        steps: Int[Array, ""],
        pull: Scalar,
        reach: Scalar,
        tool_mass: Scalar | None = None,
        spacing: Scalar | None = None,
        *moves: Float[Array, "parts nodes trials"],
    ) -> tuple[Float[Array, "samples trials"], Float[Array, "samples rows trials"]]:
        if not is_plain:
            make = partial(
                system_of, explanation, pull=pull, reach=reach, spacing=spacing, tool_mass=tool_mass
            )
            return simulate_with_derivatives(make, z, h, SAMPLES, steps, moves)

        def one(z: Float[Array, " p+2+q"], *moves: Float[Array, "parts nodes"]) -> Response:
            acting = _acting(explanation, z, *moves, reach=reach, spacing=spacing)
            return simulate(*acting, h, SAMPLES, steps, pull, tool_mass)

        found = jax.vmap(one, in_axes=(0, *(-1 for _ in moves)), out_axes=-1)(z, *moves)
        return found.contact, found.sensed[:, None]

    number = jax.ShapeDtypeStruct((), float)
    z = jax.ShapeDtypeStruct((block, len(parameters(explanation)) + 2 + ERRORS * is_moved), float)
    steps = jax.ShapeDtypeStruct((), int)
    moves = jax.ShapeDtypeStruct((1 + ERRORS, NODES, block), float)
    motion = (number, moves, moves) if is_moved else ()
    name = (
        f"forward {explanation}{' as measured' * is_moved}{' behind a tool' * has_tool}{' plain' * is_plain}"
    )
    tool = number if has_tool else None
    return kept(program, name, (z, number, steps, number, number, tool, *motion), MADE_OF)


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
    robot: RobotMotion | None = None,
    error: np.ndarray | None = None,
    steps: np.ndarray | None = None,
) -> Forces:
    """Forces of all trials and their derivatives.

    **Arguments:** `theta`: (p,) the explanation's parameters, SI units. `v_e`, `f_p`: (trials,), m/s and N. `reach`: of
    `reach_of`, where a free curve is continued beyond the trials that it was fitted to. `robot`: how it was measured to
    move in addition to v_E. `error`: (trials, q) how far that is off, in standard deviations; none is the default.
    `steps`: (trials,) how many each trial needs, where that is less than the grid has; zeros are behind them.

    **Returns:** `Forces`; not finite where the integration is unstable.
    """
    program = grid.program or explanation
    rows = _run(
        program, False, _widened(explanation, program, theta), v_e, f_p, grid, reach, robot, error, steps
    )
    if program == explanation:
        return rows
    own = places(explanation, program)
    kept = np.concatenate([[0], 1 + own, np.arange(1 + len(parameters(program)), rows.rows.shape[1])])
    return rows._replace(rows=rows.rows[:, kept])


def forward_plain(
    explanation: Explanation,
    theta: np.ndarray,
    v_e: np.ndarray,
    f_p: np.ndarray,
    grid: Grid,
    robot: RobotMotion | None = None,
    error: np.ndarray | None = None,
    steps: np.ndarray | None = None,
) -> Forces:
    """Forces of trials with parameters of their own, theta (trials, p); other arguments as of `forward`.

    One program does for all laws, most of them without strength, and one for each free curve beside laws. A free curve
    alone runs in its program with tangents, which are left out.

    **Returns:** `Forces` without tangents.
    """
    laws, curves = split(explanation)
    is_plain = bool(laws or not curves)
    program = tuple(sorted({*effects.library(), *explanation})) if is_plain else explanation
    theta = _widened(explanation, program, theta)
    found = _run(program, is_plain, theta, v_e, f_p, grid, np.inf, robot, error, steps)
    return found if is_plain else found._replace(rows=found.rows[:, :1])


def _widened(explanation: Explanation, program: Explanation, theta: np.ndarray) -> np.ndarray:
    """Parameters (..., p) of a program that has more effects, which change nothing."""
    if program == explanation:
        return theta
    rig = np.zeros((*theta.shape[:-1], len(RIG)))
    wide = np.concatenate(
        [rig, np.broadcast_to(neutral(program), (*rig.shape[:-1], len(neutral(program))))], -1
    )
    wide[..., places(explanation, program)] = theta
    return wide


def _run(
    program: Explanation,
    is_plain: bool,
    theta: np.ndarray,
    v_e: np.ndarray,
    f_p: np.ndarray,
    grid: Grid,
    reach: float,
    robot: RobotMotion | None,
    error: np.ndarray | None,
    steps: np.ndarray | None,
) -> Forces:
    """The forces that a program gives, with all derivatives that it has; theta (p,) or (trials, p)."""
    n, used = len(v_e), grid.steps + 1
    z = np.column_stack([np.broadcast_to(theta, (n, theta.shape[-1])), v_e, f_p])
    if robot:
        z = np.column_stack([z, np.zeros((n, ERRORS)) if error is None else error])
    needed = np.full(n, grid.steps) if steps is None else np.minimum(steps, grid.steps)
    contact, rows = np.zeros((n, used)), np.zeros((n, 1 if is_plain else z.shape[1] + 1, used))
    block = BLOCKS[0] if is_plain else grid.block
    run = _program(program, robot is not None, grid.tool_mass is not None, block, is_plain)
    for here in _blocks(needed, block):
        padded = here[np.arange(block) % len(here)]
        motion: tuple[Any, ...] = ()
        if robot:
            moves = robot.of(padded)
            motion = robot.spacing, *(np.moveaxis(x, 0, -1) for x in (moves.velocity, moves.displacement))
        longest = int(needed[here].max())
        found = run(z[padded], grid.h, longest, grid.pull, reach, grid.tool_mass, *motion)
        # turned here, where most of the grid is left out already
        contact[here, : longest + 1] = np.asarray(found[0])[: longest + 1, : len(here)].T
        rows[here, :, : longest + 1] = np.asarray(found[1])[: longest + 1, :, : len(here)].transpose(2, 1, 0)
    if grid.low_pass:  # linear: it does to derivatives what it does to forces
        rows[:, :, 0] /= (
            2  # the step at first contact is at time 0, not in the middle of the interval before it
        )
        rows = Filter(grid.low_pass, grid.h)(rows)
    return Forces(contact, rows)

"""One impact with effects: the classical Runge-Kutta method on a fixed grid, the sensor behind it."""

import functools
from collections.abc import Sequence
from typing import NamedTuple, TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from acf_jax.effects import AbstractEffect, Motion
from acf_jax.effects._interface import Scalar, States
from acf_jax.model import Impact, Rig

T = TypeVar("T")


class Response(NamedTuple):
    """Forces over time, sample k at k h seconds after first contact."""

    sensed: Float[Array, " samples"]  # N, what the sensor reads
    contact: Float[Array, " samples"]  # N, what acts between robot and flange


class State(NamedTuple):
    x: Scalar  # m, against a robot that keeps its speed: the paper's x where it does
    x_dot: Scalar
    # of each effect; as vectors, XLA would compute every entry with each
    states: tuple[States, ...]


def at_rest(effects: tuple[AbstractEffect, ...]) -> State:
    """The state at first contact."""
    zero = jnp.zeros(())
    return State(zero, zero, tuple((zero,) * e.n_state for e in effects))


def _add(a: State, b: State, scale: Scalar | float) -> State:
    return jax.tree.map(lambda p, q: p + scale * q, a, b)


def _once(value: T, y: State) -> T:
    """The value, which a compiler must not compute again at each place that uses it.

    Each state of an effect has its own rate of the same force, and each stage of the integration uses all rates before.
    Without such states there is nothing to save.
    """
    return jax.lax.optimization_barrier(value) if any(y.states) else value


class System(NamedTuple):
    """The equations of motion of one impact with effects."""

    rig: Rig
    impact: Impact  # as it acts
    label: Scalar  # N, pretension as commanded
    effects: tuple[AbstractEffect, ...]
    pull: Scalar
    tool_mass: Scalar | None = (
        None  # kg, of the moving mass, between the contact and the sensor; None: nothing
    )

    @property
    def sensors(self) -> tuple[AbstractEffect, ...]:
        """The effects that the force passes through, one after the other."""
        return tuple(e for e in self.effects if e.component == "sensor")

    @jax.jit  # traced once, not at each of the places that call it
    def motion(self, t: Scalar, y: State) -> Motion:
        """What acts at time t: the compression first, then the contact force (paper, Eqs. 2 and 8)."""
        rig, impact = self.rig, self.impact
        states = list(zip(self.effects, y.states, strict=True))
        robot = [e.robot_displacement(rig, impact, t, q) for e, q in states]
        pad = [e.pad_displacement(q) for e, q in states]
        carrier = [e.carrier_displacement(rig, impact, t) for e in self.effects]
        x, x_dot = y.x + sum(c[0] for c in carrier), y.x_dot + sum(c[1] for c in carrier)
        s = impact.v_e * t + sum(r[0] for r in robot) - y.x - sum(p[0] for p in pad)
        s_dot = impact.v_e + sum(r[1] for r in robot) - y.x_dot - sum(p[1] for p in pad)
        f_0 = impact.f_p - sum(e.initial_relief(impact) for e in self.effects)
        linear = rig.k_c * s + f_0
        motion = Motion(rig, impact, self.label, t, x, x_dot, s, s_dot, f_0, linear)
        f_c = linear + sum(e.contact_force(motion, q) for e, q in states)
        return motion._replace(f_c=_once(jnp.where(f_c > 0, f_c, self.pull * f_c), y))

    @jax.jit
    def rates(self, t: Scalar, y: State, free: Scalar) -> State:
        """Equation (1) with effects; `free` is the share of the step for which the flange is off its stop."""
        rig, motion = self.rig, self.motion(t, y)
        states = list(zip(self.effects, y.states, strict=True))
        force = motion.f_c + sum(e.force_on_mass(motion, q) for e, q in states)
        x_ddot = free * (force - rig.d * motion.x_dot - rig.k_f * motion.x) / rig.m
        rates = State(free * y.x_dot, x_ddot, tuple(e.rates(motion, x_ddot, q) for e, q in states))
        return _once(rates, y)

    def forces(self, t: Scalar, y: State, free: Scalar) -> tuple[Scalar, ...]:
        """Contact force, and what of it reaches a sensor on the robot's side of a tool, F_C - m_t x'', N."""
        f_c = self.motion(t, y).f_c
        return (
            (f_c,) if self.tool_mass is None else (f_c, f_c - self.tool_mass * self.rates(t, y, free).x_dot)
        )

    def free_share(self, t: Scalar, h: Scalar, y: State) -> Scalar:
        """Share of the step after the contact force has passed the force that releases a held flange."""
        holding = [f for e in self.effects if (f := e.release_force(self.impact)) is not None]
        if not holding:
            return jnp.asarray(1.0)
        release = functools.reduce(jnp.maximum, holding)
        held = self.rates(t, y, jnp.asarray(0.0))
        now = self.motion(t, y).f_c
        then = self.motion(t + h, _add(y, held, h)).f_c
        is_held = now < release
        # where the flange is free `release` may be infinite, which reverse mode would turn into NaN
        beyond = jnp.where(is_held, then - release, 0.0)
        rising = jnp.where(then > now, then - now, 1.0)
        crossing = jnp.where(beyond < 0, 0.0, beyond / rising)
        return jnp.where(is_held, crossing, 1.0)

    def step(self, t: Scalar, h: Scalar, y: State, free: Scalar) -> State:
        """The classical Runge-Kutta method of order four; a flange released within the step moves from then on."""
        span = jnp.where(free > 0, free, 1.0) * h
        t = t + (h - span)
        k_1 = self.rates(t, y, free)
        k_2 = self.rates(t + span / 2, _add(y, k_1, h / 2), free)
        k_3 = self.rates(t + span / 2, _add(y, k_2, h / 2), free)
        k_4 = self.rates(t + span, _add(y, k_3, h), free)
        return jax.tree.map(lambda y, a, b, c, d: y + h / 6 * (a + 2 * b + 2 * c + d), y, k_1, k_2, k_3, k_4)


class Moving(NamedTuple):
    """What goes from one step to the next."""

    y: State
    released: Bool[Array, ""]
    signals: tuple[
        Scalar, ...
    ]  # N, contact force, what is left of it behind a tool, that after each sensor stage
    memories: tuple[
        Float[Array, " n_memory"], ...
    ]  # of the sensor stages; none where nobody asks for the sensor


def make_system(
    rig: Rig,
    impact: Impact,
    effects: Sequence[AbstractEffect],
    pull: Scalar | float = 0.0,
    tool_mass: Scalar | float | None = None,
) -> System:
    """The equations of motion; the arguments are those of `simulate`."""
    label = jnp.asarray(impact.f_p, float)
    acting = label + sum(e.pretension_excess(impact) for e in effects)
    acting = jnp.where(acting < 0, 0.0, acting)  # a contact does not begin with a pull
    tool = None if tool_mass is None else jnp.asarray(tool_mass, float)
    return System(rig, Impact(impact.v_e, acting), label, tuple(effects), jnp.asarray(pull, float), tool)


def start(system: System, h: Scalar, has_sensor: bool = True) -> Moving:
    """The instant of first contact."""
    zero, y_0 = jnp.zeros(()), at_rest(system.effects)
    f_0 = system.forces(zero, y_0, system.free_share(zero, zero, y_0))
    memory_0 = tuple(jnp.zeros(e.n_memory) for e in system.sensors) if has_sensor else ()
    # Before contact the force is zero: a step of almost no length carries the jump to F_C(0) into the sensors. Not
    # shorter: the slope of the jump would drown their readings in rounding errors.
    silence = (zero,) * (len(f_0) + len(memory_0))
    signals_0, _ = _sense(system.sensors, silence, f_0, h * 1e-3, memory_0)
    return Moving(y_0, jnp.asarray(False), signals_0, memory_0)


def advance(system: System, k: Int[Array, ""], h: Scalar, moving: Moving) -> Moving:
    """The step from k h to (k + 1) h."""
    t = k * h
    free = jnp.where(moving.released, 1.0, system.free_share(t, h, moving.y))
    y = system.step(t, h, moving.y, free)
    released = moving.released | (free > 0)
    forces = system.forces(t + h, y, jnp.where(released, 1.0, 0.0))
    signals, memories = _sense(system.sensors, moving.signals, forces, h, moving.memories)
    return Moving(y, released, signals, memories)


def _sense(
    sensors: tuple[AbstractEffect, ...],
    before: tuple[Scalar, ...],
    forces: tuple[Scalar, ...],
    h: Scalar,
    memories: tuple[Array, ...],
) -> tuple[tuple[Scalar, ...], tuple[Array, ...]]:
    """Signals of `Moving`, from the same one step earlier; without memories nobody asks for the sensors."""
    after, kept = list(forces), []
    for e, last, memory in zip(sensors, before[len(forces) - 1 :], memories, strict=False):
        memory, reading = e.sense((last, after[-1]), h, memory)
        after.append(reading)
        kept.append(memory)
    return tuple(after), tuple(kept)


def simulate(
    rig: Rig,
    impact: Impact,
    effects: Sequence[AbstractEffect],
    h: Scalar | float,
    samples: int,
    steps: Int[Array, ""] | int | None = None,
    pull: Scalar | float = 0.0,
    tool_mass: Scalar | float | None = None,
) -> Response:
    """Sensed and contact force of one impact on the grid 0, h, 2h, ...

    m x'' + d x' + k_F x = F_C + forces of the effects, F_C = k_C s + F_P + ..., from x(0) = x'(0) = 0. A contact
    does not pull: where the law would give F_C < 0, the force is `pull` times that; `pull` = 1 is the paper's two-sided
    law, whose response after contact is lost is the equations' continuation.

    **Arguments:** `rig`, `impact`: one sample. `effects`: at most one of a kind, in any order. `h`: step in s; keep
    omega h below about 0.3 for the fastest mode. `samples`: length of the result. `steps`: how many steps to take, at
    most `samples - 1` (the default); the rest stays zero. A traced number of steps allows forward-mode
    derivatives only; a static one both modes. `tool_mass`: kg, the part m_t of the moving mass that lies between
    contact and sensor, which reads F_C - m_t x''; None: the sensor reads the contact force.

    **Returns:** a `Response` with leaves of shape `(samples,)`, in N.
    """
    h = jnp.asarray(h, float)
    system = make_system(rig, impact, effects, pull, tool_mass)
    moving_0 = start(system, h)

    def body(k: Int[Array, ""], carry: tuple[Moving, Response]) -> tuple[Moving, Response]:
        moving, out = carry
        moving = advance(system, k, h, moving)
        sensed = out.sensed.at[k + 1].set(moving.signals[-1])
        return moving, Response(sensed, out.contact.at[k + 1].set(moving.signals[0]))

    empty = jnp.zeros(samples)
    out = Response(empty.at[0].set(moving_0.signals[-1]), empty.at[0].set(moving_0.signals[0]))
    return jax.lax.fori_loop(0, samples - 1 if steps is None else steps, body, (moving_0, out))[-1]

"""What an unmodelled effect is: parameters with ranges, and the hooks through which it acts.

The simulator knows only this interface. An effect overrides the hooks it needs; every other hook keeps the
paper's model. With its strengths at zero an effect changes nothing at all, whatever its shapes are.
"""

import dataclasses
from typing import Any, ClassVar, Literal, NamedTuple, get_args

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from acf_jax.model import Impact, Rig

Scalar = Float[Array, ""]
States = tuple[Scalar, ...]
Component = Literal["actuator", "contact", "robot", "sensor"]
COMPONENTS: tuple[Component, ...] = get_args(Component)
Measure = Literal[
    "force", "frequency", "compliance", "stroke", "compression"
]  # of trials and rig, `inference.parameters.Measures`


class Parameter(NamedTuple):
    """What is known of one parameter of an effect before any data."""

    name: str
    unit: str
    low: float  # the fit stays within [low, high]
    high: float
    starts: tuple[float, ...]  # where fits begin: weak and strong
    scale: float  # a typical value: width of the prior of a strength, centre of the prior of a shape
    shape: bool  # positive, known by its order of magnitude; a strength is neutral at zero
    meaning: str
    of: Measure | None = None  # that its starts are multiples of
    looks: int = 0  # values over its range at which a fit looks before it begins: a frequency's misfit has many valleys
    within: str | None = None  # the strength that it cannot exceed: fits know its share of that
    per: str | None = None  # the shape of which it is a multiple wherever it acts: fits know the quotient
    over: tuple[str, int] | None = (
        None  # a shape, and at how many of its values a fit that has ended seeks this strength
    )
    needs: tuple[str, ...] = ()  # strengths of which one has to act for it to say anything; none named: any

    @property
    def is_size(self) -> bool:
        """Whether it says how large an effect is: a strength that is no share of another one and needs none."""
        return not (self.shape or self.within or self.needs)


def strength(
    unit: str,
    low: float,
    high: float,
    starts: tuple[float, ...],
    scale: float,
    meaning: str,
    of: Measure | None = None,
    looks: int = 0,
    within: str | None = None,
    per: str | None = None,
    over: tuple[str, int] | None = None,
    needs: tuple[str, ...] = (),
) -> Any:
    """A parameter that is neutral at 0: the size of the effect."""
    known = Parameter("", unit, low, high, starts, scale, False, meaning, of, looks, within, per, over, needs)
    return eqx.field(converter=jnp.asarray, default=0.0, metadata={"parameter": known})


def shape(
    unit: str,
    low: float,
    high: float,
    starts: tuple[float, ...],
    meaning: str,
    looks: int = 0,
    of: Measure | None = None,
    needs: tuple[str, ...] = (),
) -> Any:
    """A positive parameter that says how, not how much; without strength it has no influence."""
    scale = (low * high) ** 0.5
    known = Parameter("", unit, low, high, starts, scale, True, meaning, of, looks, needs=needs)
    return eqx.field(converter=jnp.asarray, default=known.scale, metadata={"parameter": known})


class Motion(NamedTuple):
    """What an effect can see at one instant. Positive x compresses the flange."""

    rig: Rig
    impact: Impact  # its pretension is the one that acts
    label: Scalar  # N, pretension as commanded
    t: Scalar  # s since first contact
    x: Scalar  # m, flange
    x_dot: Scalar  # m/s
    s: Scalar  # m, compression of the contact, v t - x in the paper
    s_dot: Scalar  # m/s
    f_0: Scalar  # N, contact force at first contact without dampers: F_P, less what a stop holds
    f_c: Scalar  # N, contact force (not yet known to `contact_force`, where it is the paper's)


class AbstractEffect(eqx.Module):
    """An effect that the paper's model leaves out; a subclass is one file of this folder, its id the file's name.

    `state` is what the effect integrates for itself, `n_state` numbers that start at zero.
    """

    component: ClassVar[Component]
    title: ClassVar[str]
    form: ClassVar[int] = 1  # raised where the law changes: models of another form are refused
    remedy: ClassVar[str] = ""  # what to do about it on the machine, an imperative; a free curve has none
    delays: ClassVar[bool] = False  # what it does to the reading is much like a delay
    longest_step: ClassVar[float] = float("inf")  # s, of a simulation that resolves its own dynamics
    n_state: ClassVar[int] = 0
    n_memory: ClassVar[int] = 0  # entries of the memory of `sense`; none: the sensor has no dynamics

    def robot_displacement(self, rig: Rig, impact: Impact, t: Scalar, state: States) -> tuple[Scalar, Scalar]:
        """Displacement (m) and velocity (m/s) of the robot in addition to v t."""
        return jnp.zeros_like(t), jnp.zeros_like(t)

    def carrier_displacement(self, rig: Rig, impact: Impact, t: Scalar) -> tuple[Scalar, Scalar]:
        """Displacement (m) and velocity (m/s), in addition to v t, of the robot as the carrier of the flange.

        The mass has its own inertia, so that only actuator and friction tell it that its carrier slows down.
        """
        return jnp.zeros_like(t), jnp.zeros_like(t)

    def pad_displacement(self, state: States) -> tuple[Scalar, Scalar]:
        """Displacement (m) and velocity (m/s) of the contact point relative to the flange."""
        return jnp.asarray(0.0), jnp.asarray(0.0)

    def pretension_excess(self, impact: Impact) -> Scalar:
        """By how much the pretension that acts exceeds the commanded one (N); every other hook gets what acts."""
        return jnp.asarray(0.0)

    def initial_relief(self, impact: Impact) -> Scalar:
        """By how much the contact force starts below F_P (N)."""
        return jnp.asarray(0.0)

    def release_force(self, impact: Impact) -> Scalar | None:
        """The contact force (N) above which the flange starts to move; it is free from the start by default."""
        return None

    def contact_force(self, motion: Motion, state: States) -> Scalar:
        """Contact force (N) in addition to k_C s + F_P."""
        return jnp.zeros_like(motion.t)

    def force_on_mass(self, motion: Motion, state: States) -> Scalar:
        """Force (N) on the flange mass in addition to the contact force.

        What it is at rest, with every state at zero, counts as lasting: `contact.carried`.
        """
        return jnp.zeros_like(motion.t)

    def rates(self, motion: Motion, x_ddot: Scalar, state: States) -> States:
        """Time derivative of the state."""
        return tuple(jnp.zeros(()) for _ in state)

    def sense(
        self, f: tuple[Scalar, Scalar], h: Scalar, memory: Float[Array, " n_memory"]
    ) -> tuple[Float[Array, " n_memory"], Scalar]:
        """The reading at the end of a step of h seconds over which the force went linearly from f[0] to f[1].

        Only effects at the sensor have one. `memory` starts at zero (no force before contact). Returns the new memory
        and the reading (N).
        """
        return memory, f[1]

    @classmethod
    def id(cls) -> str:
        """The name of the file that holds the effect."""
        return cls.__module__.rsplit(".", 1)[-1]

    @classmethod
    def acts_either_way(cls) -> bool:
        """Whether its size, the first strength, may be negative."""
        return cls.parameters()[0].low < 0

    @classmethod
    def parameters(cls) -> tuple[Parameter, ...]:
        """The effect's parameters in the order of its fields, strengths first."""
        known = [f for f in dataclasses.fields(cls) if "parameter" in f.metadata]
        return tuple(f.metadata["parameter"]._replace(name=f.name) for f in known)

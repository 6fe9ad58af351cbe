"""The hooks through which a cause acts at each component, and the arithmetic that serves numbers and arrays alike."""

from abc import abstractmethod
from typing import Any, ClassVar, NamedTuple

from validation.worlds.interface import AbstractCause, Array, Impact, Rig

Value = Any  # a float while integrating, an array when the solution is read out
State = Any  # the cause's own states: a sequence of values


class Motion(NamedTuple):
    """Where the flange stands."""

    t: float  # s
    x: float  # m
    x_rate: float  # m/s
    s: float  # compression of the contact, m
    s_rate: float  # m/s
    f_c: float  # contact force, N


def positive(value: Value) -> Value:
    """max(0, value)."""
    return 0.5 * (value + abs(value))


class AbstractScipyCause(AbstractCause):
    """A cause of this world, with states of its own where it has a memory."""

    stage: ClassVar[int] = 0  # laws of a later stage act on the force that earlier ones give

    def initial(self, rig: Rig, s: float, force: float) -> tuple[float, ...]:
        """Its states at first contact, at which the contact, compressed by `s`, carries `force`."""
        return ()

    def rates(self, z: State, rig: Rig, impact: Impact, now: Motion) -> tuple[float, ...]:
        """Their time derivatives."""
        return ()


class AbstractActuatorCause(AbstractScipyCause):
    component: ClassVar[str] = "actuator"

    @abstractmethod
    def opposing(self, z: State, rig: Rig, impact: Impact, now: Motion) -> float:
        """Force against the motion of the flange mass into compression, N."""

    def acting(self, pretension: float) -> float:
        """The pretension that acts where this one is commanded, N; all causes see the one that acts."""
        return pretension

    def start_share(self) -> float:
        """Share of the pretension at which contact starts."""
        return 1.0


class AbstractContactCause(AbstractScipyCause):
    component: ClassVar[str] = "contact"

    @abstractmethod
    def contact(self, force: Value, z: State, rig: Rig, impact: Impact, s: Value, s_rate: Value) -> Value:
        """The contact force, given the `force` without this cause; never negative. N."""


class AbstractSeatCause(AbstractScipyCause):
    """Something that moves between the contact and the flange mass."""

    component: ClassVar[str] = "contact"

    @abstractmethod
    def face(self, z: State) -> tuple[Value, Value]:
        """Position and velocity of the face that the robot touches, m and m/s."""

    @abstractmethod
    def transmitted(self, z: State, rig: Rig, impact: Impact, x: float, x_rate: float) -> float:
        """Force on the flange mass, N."""


class AbstractRobotCause(AbstractScipyCause):
    component: ClassVar[str] = "robot"

    @abstractmethod
    def offset(self, t: Value, z: State, rig: Rig, impact: Impact) -> tuple[Value, Value]:
        """By how much the robot leads its path v t, and the rate of that, m and m/s."""


class AbstractSensorCause(AbstractScipyCause):
    component: ClassVar[str] = "sensor"

    @abstractmethod
    def read(self, time: Array, force: Array) -> Array:
        """The reading of a force that is zero before time 0, on a uniform fine grid from 0 on, N."""

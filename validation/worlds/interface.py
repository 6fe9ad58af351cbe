"""What a world is: a rig, a hidden cause drawn at some size, and the force that its sensor reads."""

import importlib
import pkgutil
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from acf_jax.errors import InputError

Array = NDArray[np.floating[Any]]


@dataclass(frozen=True)
class Rig:
    """The four constants of the paper's model, Eq. (3)."""

    m: float  # kg
    d: float  # N s/m
    k_f: float  # N/m
    k_c: float  # N/m

    @property
    def omega(self) -> float:
        """Undamped angular frequency in contact, sqrt((k_F + k_C)/m), in rad/s."""
        return float(np.sqrt((self.k_f + self.k_c) / self.m))

    @property
    def half_period(self) -> float:
        """About the duration of the impact, pi/omega, in s."""
        return float(np.pi / self.omega)

    @property
    def impedance(self) -> float:
        """Force per contact velocity, sqrt(k_C m), in N s/m."""
        return float(np.sqrt(self.k_c * self.m))

    @property
    def typical_force(self) -> float:
        """A large force that every campaign reaches, sqrt(F_P^2 + k_C m v^2) at 90 N and 0.28 m/s, in N."""
        return float(np.hypot(90.0, 0.28 * self.impedance))


class Impact(NamedTuple):
    """One impact: contact velocity and pretension."""

    v_e: float  # m/s
    f_p: float  # N


class Response(NamedTuple):
    """What a world answers to one impact, on the times asked for up to the end of the recording."""

    time: Array  # s, shape (n,)
    sensed: Array  # N, shape (n,)
    contact: Array  # N, shape (n,)
    lost: float  # time at which contact is lost, s; infinite where it is not


class AbstractCause(ABC):
    """One physical cause with its parameters; each world says how it acts."""

    component: ClassVar[str]  # actuator, contact, robot or sensor

    @classmethod
    @abstractmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        """Draw the cause for a rig; it tends to its neutral limit with `size` and is clear at 1.

        Equal seeds draw the same form, so that only the strength follows `size`.
        """


class AbstractWorld(ABC):
    """An engine that answers impacts with or without causes.

    Its causes are the modules in the world's `causes/library` (effects of the contract) and
    `causes/beyond` (causes no library has), each with one cause in it; a new file is a new cause.
    """

    name: ClassVar[str]

    @abstractmethod
    def respond(
        self,
        rig: Rig,
        causes: Sequence[Any],
        impact: Impact,
        time: Array,
        after_loss: float = 0.0,
    ) -> Response:
        """Answer one impact without noise.

        **Arguments:** `rig`: the rig's constants. `causes`: what the paper's model leaves out; the paper's
        model where empty. `impact`: contact velocity and pretension, as they truly are. `time`: instants asked
        for, increasing, shape (n,), s; negative ones are the approach. `after_loss`: for how long the recording
        goes on once contact is lost, s.
        """

    def causes(self, folder: str = "") -> dict[str, type[AbstractCause]]:
        """Its causes by name, of one folder (`library`, `beyond`) or of both."""
        found: dict[str, type[AbstractCause]] = {}
        for place in [folder] if folder else ["library", "beyond"]:
            package = importlib.import_module(f"validation.worlds.{self.name}_world.causes.{place}")
            for entry in pkgutil.iter_modules(package.__path__):
                module = importlib.import_module(f"{package.__name__}.{entry.name}")
                found[entry.name] = _cause_in(module)
        return found

    def draw(self, name: str, seed: int, rig: Rig, size: float) -> AbstractCause:
        """Draw the named cause; equal seeds differ in strength only."""
        causes = self.causes()
        if name not in causes:
            raise InputError(f"'{name}' is not a cause of world '{self.name}'; it has {', '.join(causes)}")
        return causes[name].draw(np.random.default_rng(seed), rig, size)


def _cause_in(module: ModuleType) -> type[AbstractCause]:
    (cause,) = (
        value
        for value in vars(module).values()
        if isinstance(value, type)
        and issubclass(value, AbstractCause)
        and value.__module__ == module.__name__
    )
    return cause


def find_world(name: str) -> AbstractWorld:
    """The world in the folder `<name>_world` beside this file; `InputError` where there is none."""
    package = importlib.import_module("validation.worlds")
    names = [m.name.removesuffix("_world") for m in pkgutil.iter_modules(package.__path__) if m.ispkg]
    if name not in names:
        raise InputError(f"world '{name}' does not exist; there are {', '.join(names)}")
    try:
        world: AbstractWorld = importlib.import_module(f"validation.worlds.{name}_world").world
    except ModuleNotFoundError as error:
        raise InputError(
            f"world '{name}' needs the package {error.name}; run `pip install {error.name}`"
        ) from None
    return world

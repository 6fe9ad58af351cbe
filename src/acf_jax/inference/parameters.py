"""What a diagnosis may fit: the rig's four parameters, then those of an explanation's effects."""

import functools
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from acf_jax.dataset import RigPrior
from acf_jax.effects import AbstractEffect, Parameter, library
from acf_jax.inference.free_curves import free_curves

RIG = (
    Parameter("moving_mass_kg", "kg", 0.0, np.inf, (), 1.0, False, "moving mass m"),
    Parameter("damping_n_s_per_m", "N s/m", 0.0, np.inf, (), 1.0, False, "damping d"),
    Parameter("actuator_stiffness_n_per_m", "N/m", 0.0, np.inf, (), 1.0, False, "actuator stiffness k_F"),
    Parameter("contact_stiffness_n_per_m", "N/m", 0.0, np.inf, (), 1.0, False, "contact stiffness k_C"),
)
LEAST_SHARE = np.array(
    [0.05, 0.0, 0.0, 0.02]
)  # of a rig parameter's prior value: mass and contact never vanish
RIG_BOUNDS = (
    (1e-3, 1e4),
    (0.0, 1e7),
    (0.0, 1e9),
    (1.0, 1e11),
)  # far beyond what a data set may state, SI units
ROUNDING = 1e-12  # of a value: closer to zero it is zero
COMMON = 2  # what all trials share: the sensor's zero, N, and the delay of all triggers, s; waves come behind
PRIOR_WIDTH = 3.0  # width of the prior of a strength, in its typical values
PART = 0.5  # width of the prior of a strength within another, of which all is expected

Explanation = tuple[
    str, ...
]  # ids of effects in alphabetical order, or of one free curve; () is the paper's model


@functools.cache
def every_effect() -> dict[str, type[AbstractEffect]]:
    """The library and the four free curves by id."""
    return {**library(), **free_curves()}


def is_free_curve(explanation: Explanation) -> bool:
    """Whether a free curve, which stands for an unknown cause, is the explanation or a part of it."""
    return any(name in free_curves() for name in explanation)


def split(explanation: Explanation) -> tuple[Explanation, Explanation]:
    """The laws of an explanation, and its free curves."""
    curves = tuple(name for name in explanation if name in free_curves())
    return tuple(name for name in explanation if name not in curves), curves


def classes(explanation: Explanation) -> list[type[AbstractEffect]]:
    """The effects of an explanation."""
    return [every_effect()[name] for name in explanation]


def parameters(explanation: Explanation) -> list[tuple[str, Parameter]]:
    """Every physical parameter with its full name, `effect.parameter` behind the rig's."""
    of_effects = [(f"{name}.{p.name}", p) for name in explanation for p in every_effect()[name].parameters()]
    return [(p.name, p) for p in RIG] + of_effects


def neutral(explanation: Explanation) -> np.ndarray:
    """Parameters of effects that change nothing: no strength, and each shape as it is typical."""
    known = (p for name in explanation for p in every_effect()[name].parameters())
    return np.array([p.scale if p.shape else 0.0 for p in known])


def rests(explanation: Explanation) -> list[Explanation]:
    """An explanation without each of its effects, in their order."""
    return [tuple(other for other in explanation if other != name) for name in explanation]


def switched_off(explanation: Explanation, physical: np.ndarray, off: Iterable[str]) -> np.ndarray:
    """The parameters of rig and effects with some of the effects neutral."""
    found = physical.copy()
    for name in off:
        found[places((name,), explanation)[len(RIG) :]] = neutral((name,))
    return found


def places(explanation: Explanation, among: Explanation) -> np.ndarray:
    """Where the parameters of rig and effects of an explanation stand among those of one that has more effects."""
    names = [name for name, _ in parameters(among)]
    return np.array([names.index(name) for name, _ in parameters(explanation)])


class Coordinates(NamedTuple):
    """Free parameters in units of their priors: u has a standard normal prior within its bounds.

    A strength is linear in u, a shape parameter exponential. Of a strength within another the share of that is linear:
    what cannot exceed the other one has a kink there, along which no fit would find its way. Of one that acts per
    shape the quotient is: a curved valley, along which nothing changes, becomes a straight one.
    """

    centre: np.ndarray  # (p,) value at u = 0
    width: np.ndarray  # (p,) prior standard deviation, of the logarithm for a shape
    logarithmic: np.ndarray  # (p,) bool
    low: np.ndarray  # (p,) bounds in u
    high: np.ndarray
    of: np.ndarray  # (p,) int, of which parameter this one is a share or multiple: itself, where of no other
    unit: np.ndarray  # (p,) in units of what that one counts

    def value(self, u: np.ndarray) -> np.ndarray:
        """The parameters in SI units."""
        alone = self._alone(u)
        return np.where(self.is_part, alone * alone[..., self.of] / self.unit, alone)

    def jacobian(self, u: np.ndarray) -> np.ndarray:
        """(p, p) d value / d u."""
        alone = self._alone(u)
        slope = np.where(self.logarithmic, alone * self.width, self.width)
        whole = np.where(self.is_part, alone[self.of] / self.unit, 1.0)
        found = np.diag(slope * whole)
        for k in np.flatnonzero(self.is_part):
            found[k, self.of[k]] = alone[k] * slope[self.of[k]] / self.unit[k]
        return found

    def coordinate(self, value: np.ndarray) -> np.ndarray:
        """The inverse of `value`; of nothing all is a share."""
        whole = value[self.of] / self.unit
        part = np.where(whole > 0, value, 1.0) / np.where(whole > 0, whole, 1.0)
        alone = np.where(self.is_part, part, value)
        ratio = np.where(self.logarithmic, alone, 1.0) / np.where(self.logarithmic, self.centre, 1.0)
        return np.where(self.logarithmic, np.log(ratio), alone - self.centre) / self.width

    @property
    def is_part(self) -> np.ndarray:
        """(p,) bool, whether it is a share or multiple of another one."""
        return np.not_equal(self.of, np.arange(len(self.of)))

    def _alone(self, u: np.ndarray) -> np.ndarray:
        """The parameters, or of what others they are which share or multiple."""
        z = self.width * u
        linear = self.centre + z
        linear = np.where(np.abs(linear) < ROUNDING * np.abs(self.centre), 0.0, linear)  # at a bound of zero
        return np.where(self.logarithmic, self.centre * np.exp(np.where(self.logarithmic, z, 0.0)), linear)


def coordinates(
    prior: RigPrior, explanation: Explanation, common_std: Sequence[float] = (1.0, 1.0)
) -> Coordinates:
    """Priors and bounds of the rig's parameters, an explanation's, and of what all trials share."""
    value, std = prior.values, prior.stds
    rows = [
        (
            value[i],
            std[i],
            False,
            (LEAST_SHARE[i] - 1) * value[i] / std[i],
            (RIG_BOUNDS[i][1] - value[i]) / std[i],
        )
        for i in range(len(RIG))
    ]
    known = parameters(explanation)
    of = np.arange(len(known) + len(common_std))
    unit = np.ones(len(of))
    for k, (name, p) in enumerate(known[len(RIG) :], len(RIG)):
        if other := p.within or p.per:
            of[k] = [known_name for known_name, _ in known].index(f"{name.split('.')[0]}.{other}")
            unit[k] = known[of[k]][1].scale if p.per else 1.0
        if p.within:
            rows.append((1.0, PART, False, -1 / PART, 0.0))
        elif p.shape:
            width = np.log(p.high / p.low) / 4
            rows.append(
                (p.scale, width, True, np.log(p.low / p.scale) / width, np.log(p.high / p.scale) / width)
            )
        else:
            width = PRIOR_WIDTH * p.scale
            rows.append((0.0, width, False, p.low / width, p.high / width))
    rows += [(0.0, std, False, -6.0, 6.0) for std in common_std]
    centre, width, logarithmic, low, high = (np.array(column) for column in zip(*rows, strict=True))
    return Coordinates(centre, width, logarithmic, low, high, of, unit)


def begin(rig: np.ndarray, *of_effects: Sequence[float] | np.ndarray) -> np.ndarray:
    """Parameters to begin a fit with: the rig's, those of effects, and nothing that all trials share."""
    return np.concatenate([rig, *of_effects, np.zeros(COMMON)])


class Measures(NamedTuple):
    """What is typical of a rig and its trials: some starts are multiples of it."""

    force: float = 200.0  # N, the largest one
    frequency: float = 50.0  # Hz, of the moving mass on the contact
    compliance: float = 1e-3  # m, compression of the contact under 100 N
    stroke: float = 2e-3  # m, of half a period at 0.2 m/s
    compression: float = 2e-3  # m, of the contact under the largest force


TYPICAL = Measures()


def starts(name: str, measures: Measures = TYPICAL) -> list[list[float]]:
    """Values of an effect's parameters from which fits begin: weak and strong, each shape at its own starts."""
    known = every_effect()[name].parameters()
    n = max(len(p.starts) for p in known)

    def start(p: Parameter, k: int) -> float:
        value = p.starts[min(k * len(p.starts) // n, len(p.starts) - 1)]
        return min(max(value * getattr(measures, p.of), p.low), p.high) if p.of else value

    return [[start(p, k) for p in known] for k in range(n)]


def looks(name: str, measures: Measures = TYPICAL) -> list[list[float]]:
    """The first start of an effect with such a parameter, as a frequency, at values over its range.

    Of one that may be zero these are its four highest decades: less of it is to be told to first order.
    """
    known, first = every_effect()[name].parameters(), starts(name, measures)[0]
    return [
        [*first[:k], float(value), *first[k + 1 :]]
        for k, p in enumerate(known)
        if p.looks
        for value in np.geomspace(max(p.low, 1e-4 * p.high), p.high, p.looks)
    ]


def component_of(name: str) -> str:
    """The component at which an effect or free curve acts."""
    return every_effect()[name].component


def delays(explanation: Explanation) -> bool:
    """Whether a delay common to all triggers may as well be the sensor's."""
    return any(cls.delays for cls in classes(explanation))


def label(explanation: Explanation) -> str:
    """An explanation in words."""
    return " and ".join(cls.title for cls in classes(explanation)) or "nothing unmodelled"

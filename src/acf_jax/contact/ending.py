"""How a contact ends, as a user states it."""

import math
from collections.abc import Mapping
from typing import NamedTuple

from jaxtyping import Array, Float

from acf_jax.dataset.units import Limit

Scalar = Float[Array, ""] | float

LIMITS = {
    "stop_after": Limit("s", 1e-4, 10.0, too_high="if it is in ms, divide by 1000"),
    "travel": Limit("m", 1e-5, 2.0, too_high="if it is in mm, divide by 1000"),
    "reaction": Limit("s", 1e-4, 10.0, too_high="if it is in ms, divide by 1000"),
    "deceleration": Limit("m/s^2", 0.01, 200.0, too_high="if it is in mm/s^2, divide by 1000"),
}


class Ending(NamedTuple):
    """What is known of the robot's stop, each counted from first contact; infinite where it is not.

    Either the robot has stopped after `stop_after` and keeps its speed until then, or it brakes with `deceleration`
    from `reaction` on. Its travel until it has stopped must not exceed `travel`; alone, that says when it stops.
    """

    stop_after: Scalar = math.inf  # s
    travel: Scalar = math.inf  # m, what is left of the flange's stroke or of the robot's way
    reaction: Scalar = math.inf  # s, from when the robot brakes
    deceleration: Scalar = math.inf  # m/s^2, with which it does

    @property
    def is_known(self) -> bool:
        """Whether anything but infinity is there, outside a traced program."""
        return not all(map(math.isinf, self))

    @property
    def brakes(self) -> bool:
        """Whether the robot's braking is known, outside a traced program."""
        return not math.isinf(self.deceleration)


OPEN = Ending()


def make_ending(
    given: Mapping[str, float | None], names: Mapping[str, str] | None = None
) -> tuple[Ending, list[str]]:
    """The ending that is given by field, None for what is not known, and what is wrong with it.

    **Arguments:** `names`: what the fields are called where the user wrote them.
    """
    called = {name: (names or {}).get(name, name) for name in given}
    ending = Ending(**{name: math.inf if value is None else value for name, value in given.items()})
    faults = [
        f"{called[name]} must be a finite number, but is inf" for name, x in given.items() if x == math.inf
    ]
    return ending, faults or ending_faults(ending, names)


def ending_faults(ending: Ending, names: Mapping[str, str] | None = None) -> list[str]:
    """What is wrong with an ending: `name message` each, with the remedy.

    **Arguments:** `names`: what the fields are called where the user wrote them.
    """
    called = {name: (names or {}).get(name, name) for name in LIMITS}
    faults = []
    for name, limit in LIMITS.items():
        value = float(getattr(ending, name))
        if value == math.inf or (value == 0 and name == "reaction"):
            continue
        fault = (
            limit.fault(value)
            if value > 0
            else f"must be positive, in {limit.unit}, but is {value:g}; correct it"
        )
        faults += [f"{called[name]} {fault}"] if fault else []
    reaction, deceleration = called["reaction"], called["deceleration"]
    if math.isinf(ending.reaction) != math.isinf(ending.deceleration):
        faults.append(f"{deceleration} and {reaction} belong together; give both or neither")
    elif ending.brakes and not math.isinf(ending.stop_after):
        faults.append(
            f"{called['stop_after']} and {deceleration} both say when the robot stops; give one of them"
        )
    return faults

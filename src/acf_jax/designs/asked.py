"""How fast may the flange be? The question, which is looked at before JAX is loaded."""

from collections.abc import Callable
from typing import NamedTuple

from acf_jax.contact.ending import OPEN, Ending
from acf_jax.dataset.units import value_fault

PROBABILITY = (0.5, 0.9999)  # that can be asked for


class Asked(NamedTuple):
    """The contact velocity is free and to be as high as possible; all else is given."""

    f_p: float  # N, pretension
    limits: tuple[float, ...]  # N, of the peak contact force
    ending: Ending = OPEN  # how the contact ends; the first peak alone counts without
    probability: float = 0.95  # that a limit holds
    draws: int = 8192  # of everything uncertain
    up_to: float = 2.0  # m/s, highest velocity looked at


def asked_faults(asked: Asked, called: Callable[[str], str] = str) -> list[str]:
    """What is wrong with a question, whatever the model.

    **Arguments:** `called`: from a field, `limit` for one of `limits`, to what the user calls it.
    """
    found = [
        value_fault("f_p", asked.f_p, called("f_p")),
        *(value_fault("limit", limit, called("limit")) for limit in asked.limits),
    ]
    low, high = PROBABILITY
    if not low <= asked.probability <= high:
        found.append(
            f"{called('probability')} must lie between {low} and {high}, but is {asked.probability!r}"
        )
    if asked.up_to <= 0:
        found.append(f"{called('up_to')} must be above 0 m/s, but is {asked.up_to!r}")
    else:
        found.append(value_fault("v_e", asked.up_to, called("up_to")))
    return list(filter(None, found))

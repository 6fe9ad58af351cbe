"""How far one may go along a line until something stops holding, to the last digit."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

POINTS = 16
LAST_DIGIT = 4e-16


class Crossing(NamedTuple):
    """Neighbours on either side of the first change, as shares of the line."""

    last_held: float
    first_failed: float  # infinite where it holds to the end


def first_failure(
    holds: Callable[[np.ndarray], np.ndarray], start: float = 0.0, within: float = LAST_DIGIT
) -> Crossing | None:
    """Where on [start, 1] `holds` first fails, by dividing the line into 16 again and again.

    **Arguments:** `holds`: shares (16,) to booleans (16,). A failure narrower than a fifteenth of the line can be
    missed. `within`: the neighbours' distance over their value; by default they are neighbouring numbers.

    **Returns:** two numbers on the right sides of the crossing, or None where `holds` fails at the start already.
    """
    low, high = start, 1.0
    failed = np.inf
    while True:
        shares = np.linspace(low, high, POINTS)
        held = holds(shares)
        if not held[0]:  # at the start: what once held holds again
            return None
        at = int(np.argmin(held))
        if held[at]:
            return Crossing(1.0, np.inf)
        low, high, failed = float(shares[at - 1]), float(shares[at]), float(shares[at])
        if np.nextafter(low, 1.0) >= high or (high - low) <= within * high:
            return Crossing(low, failed)

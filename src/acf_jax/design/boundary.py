"""How far one may go along a line until something stops holding, to the last digit."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

POINTS = 16


class Crossing(NamedTuple):
    """Neighbours on either side of the first change, as shares of the line."""

    last_held: float
    first_failed: float  # infinite where it holds to the end


def first_failure(holds: Callable[[np.ndarray], np.ndarray]) -> Crossing | None:
    """Where on [0, 1] `holds` first fails, by dividing the line into 16 again and again.

    **Arguments:** `holds`: shares (16,) to booleans (16,). A failure narrower than a fifteenth of the line can be
    missed.

    **Returns:** two neighbouring floating-point numbers, on the right sides of the crossing, or None where `holds`
    fails at 0 already.
    """
    low, high = 0.0, 1.0
    failed = np.inf
    while True:
        shares = np.linspace(low, high, POINTS)
        held = holds(shares)
        if low == 0.0 and not held[0]:
            return None
        at = int(np.argmin(held))
        if held[at]:
            return Crossing(1.0, np.inf)
        low, high, failed = float(shares[at - 1]), float(shares[at]), float(shares[at])
        if np.nextafter(low, 1.0) >= high or (high - low) <= 4e-16 * high:
            return Crossing(low, failed)

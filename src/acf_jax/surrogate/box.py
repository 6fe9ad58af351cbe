"""The parameter box of a surrogate: which samples lie in it, and what to say of those that do not."""

from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from acf_jax.model import Impact, Rig

UNITS = {"m": "kg", "zeta": "1", "k_f": "N/m", "k_c": "N/m", "v_e": "m/s", "f_p": "N"}

# Values that were computed, such as zeta from d, may miss the box's face by rounding.
_ROUNDING = 1e-5


def sign_fault(name: str, low: float) -> str | None:
    """Why the range of a quantity of rig or impact cannot begin at `low`; None where it can, and for any other."""
    if name in ("m", "k_c", "v_e") and low <= 0:
        return f"low must be above 0, but is {low:g}; the model needs a positive {name}"
    if name in ("d", "zeta", "k_f", "f_p", "mobility") and low < 0:
        return f"low must be 0 or above, but is {low:g}; correct it"
    return None


@dataclass(frozen=True)
class Box:
    """Lowest and highest value of m, zeta (which stands for d), k_F, k_C, v_E and F_P, in SI units."""

    low: tuple[float, ...]
    high: tuple[float, ...]

    def span(self, name: str) -> tuple[float, float] | None:
        """Lowest and highest value of a quantity; None for one that the box does not name."""
        return dict(zip(UNITS, zip(self.low, self.high, strict=True), strict=True)).get(name)

    def has(self, rig: Rig, impact: Impact) -> Bool[Array, "6"]:
        """Which of the six values of one sample lie in the box."""
        x, (low, high) = _values(rig, impact), limits(self)
        return (x >= low) & (x <= high)

    def faults(self, rig: Rig, impact: Impact, inside: np.ndarray) -> list[str]:
        """One line for each parameter that leaves the box, given `inside` of shape (N, 6)."""
        found = []
        rows = np.stack([np.ravel(x) for x in _values(rig, impact)], axis=-1)
        for i, (name, unit) in enumerate(UNITS.items()):
            outside = np.flatnonzero(~inside[:, i])
            if outside.size:
                of_unit = "" if unit == "1" else f" {unit}"
                found.append(
                    f"{name} must be {self.low[i]:g} to {self.high[i]:g}{of_unit}, but is "
                    f"{rows[outside[0], i]:g} in sample {outside[0]}{_and_more(outside.size)}"
                )
        return found


def limits(box: Box) -> np.ndarray:
    """Lowest and highest value that count as in the box, (2, 6)."""
    low, high = np.array(box.low), np.array(box.high)
    slack = _ROUNDING * np.maximum(np.abs(low), np.abs(high))
    return np.stack([low - np.minimum(slack, _ROUNDING * (high - low)), high + slack])


def _values(rig: Rig, impact: Impact) -> Float[Array, "6 *batch"]:
    return jnp.stack([rig.m, rig.zeta, rig.k_f, rig.k_c, impact.v_e, impact.f_p])


def _and_more(count: int) -> str:
    return f" (and {count - 1} more)" if count > 1 else ""

"""Which contact velocities and pretensions measurements stand behind."""

from itertools import combinations
from typing import NamedTuple

Range = tuple[float, float]
Condition = tuple[float, float]  # v_E in m/s, F_P in N
ROUNDING = 1e-9


class Tried(NamedTuple):
    """The range of the trials, and where the corners of the region that they enclose are known, that region."""

    v_e: Range  # m/s
    f_p: Range  # N
    corners: tuple[Condition, ...] = ()

    def speeds_at(self, f_p: float) -> Range:
        """Lowest and highest velocity between the trials at a pretension; the whole range where none is between."""
        if not self.corners or not self.f_p[0] <= f_p <= self.f_p[1]:
            return self.v_e
        speeds = [v for v, f in self.corners if f == f_p]
        for (v_1, f_1), (v_2, f_2) in combinations(self.corners, 2):
            if min(f_1, f_2) < f_p < max(f_1, f_2):
                speeds.append(v_1 + (v_2 - v_1) * (f_p - f_1) / (f_2 - f_1))
        return min(speeds), max(speeds)

    def beyond(self, v_e: float, f_p: float) -> list[str]:
        """What of a contact lies outside, in words."""
        rows = (("v_e", "m/s", v_e, self.v_e), ("f_p", "N", f_p, self.f_p))
        faults = [
            f"{name} = {value:g} {unit} lies outside the tried {low:g} to {high:g} {unit}"
            for name, unit, value, (low, high) in rows
            if not low <= value <= high
        ]
        if faults:
            return faults
        low, high = self.speeds_at(f_p)
        if low * (1 - ROUNDING) <= v_e <= high * (1 + ROUNDING):
            return []
        return [
            f"v_e = {v_e:g} m/s was tried, and f_p = {f_p:g} N, but not together: with that pretension only"
            f" {low:g} to {high:g} m/s lie between the trials"
        ]

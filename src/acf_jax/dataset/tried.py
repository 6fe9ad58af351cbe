"""Which contact velocities and pretensions measurements stand behind."""

from itertools import combinations
from typing import NamedTuple

Range = tuple[float, float]
Condition = tuple[float, float]  # v_E in m/s, F_P in N
FIGURES = (
    3  # with which reports and the terminal name a speed and a pretension: one that reads the same was tried
)

REACH = 2.0  # standard deviations between a commanded value and that of a trial


class Tried(NamedTuple):
    """The range of the trials, and where the corners of the region that they enclose are known, that region."""

    v_e: Range  # m/s
    f_p: Range  # N
    corners: tuple[Condition, ...] = ()
    spread: tuple[float, float] = (0.0, 0.0)  # relative std of v_E and F_P about what is commanded

    def speeds_at(self, f_p: float) -> Range:
        """Lowest and highest velocity between the trials at a pretension; the whole range where none is between."""
        if not self.corners or not _lies(f_p, self.f_p, self.spread[1]):
            return self.v_e
        f_p = min(max(f_p, self.f_p[0]), self.f_p[1])
        speeds = [v for v, f in self.corners if f == f_p]
        for (v_1, f_1), (v_2, f_2) in combinations(self.corners, 2):
            if min(f_1, f_2) < f_p < max(f_1, f_2):
                speeds.append(v_1 + (v_2 - v_1) * (f_p - f_1) / (f_2 - f_1))
        return min(speeds), max(speeds)

    def beyond(self, v_e: float, f_p: float) -> list[str]:
        """What of a contact lies outside, in words."""
        of_v_e, of_f_p = self.spread
        rows = (("v_e", "m/s", v_e, self.v_e, of_v_e), ("f_p", "N", f_p, self.f_p, of_f_p))
        faults = [
            f"{name} = {value:g} {unit} lies outside the tried {low:g} to {high:g} {unit}"
            for name, unit, value, (low, high), spread in rows
            if not _lies(value, (low, high), spread)
        ]
        if faults:
            return faults
        low, high = self.speeds_at(f_p)
        if _lies(v_e, (low, high), of_v_e):
            return []
        return [
            f"v_e = {v_e:g} m/s was tried, and f_p = {f_p:g} N, but not together: with that pretension only"
            f" {low:g} to {high:g} m/s lie between the trials"
        ]


def _lies(value: float, span: Range, spread: float) -> bool:
    """Whether a value lies in a range: no farther outside than a trial at its end may have been from its command.

    A robot that is told 0.35 m/s says 0.3493 m/s. What reads the same with three figures is the same anyway.
    """
    low, high = span[0] * (1.0 - REACH * spread), span[1] * (1.0 + REACH * spread)
    least, x, most = (float(f"{number:.{FIGURES}g}") for number in (low, value, high))
    return least <= x <= most

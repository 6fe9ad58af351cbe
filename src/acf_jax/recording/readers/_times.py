"""Times of the rows of a table: from its columns, whose names or else values tell them, or from a sampling interval."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from acf_jax.errors import InputError
from acf_jax.recording.readers._words import is_stamp, is_time, is_unit, pairs, speaks_of_time
from acf_jax.recording.series import Nanoseconds

Clock = tuple[str, ...]  # columns whose sum is the time
Stamps = tuple[Nanoseconds, NDArray[np.bool_]]  # times, ns, and where they are known

_BEYOND = (
    "holds times beyond a century; state the seconds in its unit in the --mapping file"
    " (time_scale: 1.0e-9 for ns)"
)
_LATEST = 4.1e9  # s since 1970: the year 2099
_SEARCHED = 200  # columns, of each of which the beginning is read
_FEW = 3  # rows that show nothing
_DAY = 86_400 * 10**9  # ns
_TICK = 10**9  # ns: a column of whole numbers that counts rows rises by this, were it a time in seconds


class Step(NamedTuple):
    """Rows at regular intervals."""

    start: int  # ns
    seconds: float

    def stamps(self, first: int, count: int) -> Nanoseconds:
        """Times of `count` rows from row `first` on, ns."""
        return self.start + np.rint((first + np.arange(count)) * (1e9 * self.seconds)).astype(np.int64)


def usual_scale(values: NDArray[np.generic]) -> float | None:
    """Seconds in the unit of times that do not say it: the largest of s, ms, us, ns in which they are before 2100."""
    if values.dtype.kind not in "fiu":
        return 1.0
    finite = values[np.isfinite(values)]
    if not finite.size:
        return None
    first = abs(float(finite[0]))
    return next((scale for scale in (1.0, 1e-3, 1e-6) if first * scale < _LATEST), 1e-9)


def nanoseconds(values: NDArray[np.generic], scale: float, where: str) -> Stamps:
    """Times in ns of a column of dates or numbers, whole numbers exactly; `where` names it in an `InputError`."""
    if values.dtype.kind == "M":
        return values.astype("datetime64[ns]").astype(np.int64), ~np.isnat(values)
    if values.dtype.kind not in "fiub" or values.ndim != 1:
        raise InputError(f"{where}: holds no numbers; name another column")
    known = np.isfinite(values)
    if np.any(np.abs(values[known], dtype=float) > 2.0**62 / (1e9 * scale)):
        raise InputError(f"{where}: {_BEYOND}")
    numbers: Any = np.where(known, values, 0)
    factor = round(1e9 * scale)
    if factor < 1 or abs(factor - 1e9 * scale) > 1e-6:
        return np.rint(numbers * (1e9 * scale)).astype(np.int64), known
    # whole units apart: they are exact as integers where their ns, as floats, are not
    whole = numbers.astype(np.int64)
    return whole * factor + np.rint((numbers - whole) * factor).astype(np.int64), known


@dataclass
class Days:
    """How often the times of day of a table have passed midnight: a clock is never set back by half a day."""

    past: int = 0
    last: int = 0  # time of day, ns

    def since_first(self, time: Nanoseconds) -> Nanoseconds:
        """The next times, ns since the midnight before the first of all; dates stay."""
        if not time.size or not ((time >= 0) & (time < _DAY)).all():
            return time
        past = self.past + np.cumsum(np.diff(time, prepend=self.last) < -_DAY // 2)
        self.past, self.last = int(past[-1]), int(time[-1])
        return time + past * _DAY


def find_clocks(
    names: Sequence[str], units: Mapping[str, str], first: Callable[[Clock], Stamps | None]
) -> list[Clock]:
    """What may be the time of a table: one clock where it is clear, none where nothing tells.

    A ROS message's stamp, filled and rising, is the time of the measurement itself; next come columns that are called
    a time and nothing else, then those that speak of it and rise, at last the ones that rise in every row.

    **Arguments:** columns; their units from a row of units; the first times of a clock, None where it has none.
    """
    stamps: list[Clock] = [*pairs(names), *((name,) for name in names if is_stamp(name))]
    stamps = [clock for clock in stamps if _rises(first(clock), strictly=True)]
    if len(stamps) == 1:
        return stamps
    called: list[Clock] = [(name,) for name in names if is_time(name)]
    blank = [clock for clock in called if (seen := first(clock)) is not None and not seen[1].any()]
    called = [clock for clock in called if clock not in blank]
    if len(called) > 1:  # a time that is known in every row is that of all signals
        rising = [clock for clock in called if _rises(first(clock))]
        return [clock for clock in rising if _is_filled(first(clock))] or rising or called
    if called:
        return called
    likely: list[Clock] = [(name,) for name in names if speaks_of_time(name) or is_unit(units.get(name, ""))]
    likely = [clock for clock in likely if _rises(first(clock))]
    if likely:
        return likely
    others = names if len(names) <= _SEARCHED else ()
    return [(name,) for name in others if _rises(first((name,)), strictly=True, but_counts=True)] or blank


def _is_filled(seen: Stamps | None) -> bool:
    return seen is not None and bool(seen[1].all())


def _rises(seen: Stamps | None, strictly: bool = False, but_counts: bool = False) -> bool:
    """Whether times increase; `strictly`: in every row, and none is missing; `but_counts`: they do not number rows."""
    if seen is None:
        return False
    time, known = seen
    steps = np.diff(time[known])
    if but_counts and (steps == _TICK).all():
        return False
    if strictly:
        return _is_filled(seen) and steps.size >= _FEW and bool((steps > 0).all())
    return bool((steps >= 0).all() and (steps > 0).any())

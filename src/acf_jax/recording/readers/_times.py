"""Times of the rows of a table: from its columns, whose names or else values tell them, or from a sampling interval."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
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
_SEARCHED = 200  # columns, of each of which the beginning is read at most
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
    look = cache(lambda clock: _Look.at(first(clock)))

    def those(clocks: list[Clock], hold: Callable[[_Look], bool]) -> list[Clock]:
        """The clocks of which that holds; all where they are too many to be read."""
        return clocks if len(clocks) > _SEARCHED else [clock for clock in clocks if hold(look(clock))]

    stamps: list[Clock] = [*pairs(names), *((name,) for name in names if is_stamp(name))]
    stamps = those(stamps, lambda seen: seen.always_rises)
    if len(stamps) == 1:
        return stamps
    called: list[Clock] = [(name,) for name in names if is_time(name)]
    filled = those(called, lambda seen: not seen.is_blank)
    if len(filled) > 1:  # a time that is known in every row is that of all signals
        rising = those(filled, lambda seen: seen.rises)
        return those(rising, lambda seen: seen.is_filled) or rising or filled
    if filled:
        return filled
    likely: list[Clock] = [(name,) for name in names if speaks_of_time(name) or is_unit(units.get(name, ""))]
    if likely := those(likely, lambda seen: seen.rises):
        return likely
    others: list[Clock] = [(name,) for name in names] if len(names) <= _SEARCHED else []
    return those(others, lambda seen: seen.always_rises and not seen.counts_rows) or called


class _Look(NamedTuple):
    """What the first times of a clock are."""

    is_blank: bool = False
    is_filled: bool = False  # none is missing
    rises: bool = False
    always_rises: bool = False  # in every row, and none is missing
    counts_rows: bool = False  # whole numbers that rise by one

    @classmethod
    def at(cls, seen: Stamps | None) -> "_Look":
        """Of times and where they are known; nothing holds where there are none."""
        if seen is None:
            return cls()
        time, known = seen
        steps = np.diff(time[known])
        is_filled = bool(known.all())
        return cls(
            not known.any(),
            is_filled,
            bool((steps >= 0).all() and (steps > 0).any()),
            is_filled and steps.size >= _FEW and bool((steps > 0).all()),
            bool((steps == _TICK).all()),
        )

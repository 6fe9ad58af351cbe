"""What tables of every kind share: signals by name, their times, rows without a value."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acf_jax.errors import InputError, shown, suggestion
from acf_jax.recording.mapping import Mapping as Stated
from acf_jax.recording.mapping import Source
from acf_jax.recording.readers._guard import some
from acf_jax.recording.readers._times import Clock, Days, Stamps, Step, find_clocks, nanoseconds, usual_scale
from acf_jax.recording.readers._words import (
    NUMBERED,
    groups,
    in_brackets,
    is_called,
    is_time,
    is_unit,
    last_part,
    speaks_of_time,
    unit_of,
)
from acf_jax.recording.series import Array, Channel, Growing, Progress, Series

Chunk = Mapping[str, NDArray[np.generic]]
# The chunks of rows of some columns, in order.
Chunks = Callable[[Sequence[str], Progress], Iterator[Chunk]]
_MOST = 10_000  # columns


def unique(names: Sequence[str]) -> list[str]:
    """A name for every column: its number where it has none, a number behind where several are called the same."""
    filled = [name.strip() or f"column {i}" for i, name in enumerate(names, 1)]
    total, seen = Counter(filled), Counter[str]()
    result = []
    for name in filled:
        seen[name] += 1
        result.append(f"{name} ({seen[name]})" if total[name] > 1 else name)
    return result if len(set(result)) == len(result) else unique(result)


class _Regular(NamedTuple):
    """Rows at regular intervals, and their number where it is known."""

    step: Step
    rows: int | None


class Table:
    """A recording in columns; a row of which a value is missing is no sample of that signal.

    **Arguments:** file; columns; their chunks of rows; what the user stated; `units` from a row of units, by column;
    `steps` of columns that bring an interval; `notes` on how it was read; `fault`, told where a signal is missing.
    """

    def __init__(
        self,
        path: Path,
        columns: Sequence[Channel],
        chunks: Chunks,
        stated: Stated,
        *,
        units: Mapping[str, str] | None = None,
        steps: Mapping[str, Step] | None = None,
        notes: Sequence[str] = (),
        fault: str | None = None,
    ):
        if not 0 < len(columns) <= _MOST:
            remedy = "keep those that are needed" if columns else "write times and signals into it"
            raise InputError(f"{path}: holds {len(columns):,} columns; {remedy}")
        self.path, self.columns, self.chunks, self.stated = path, list(columns), chunks, stated
        self.names = [column.name for column in columns]
        self.units, self.steps, self.notes, self.fault = units or {}, steps or {}, notes, fault
        self._scales: dict[str, float] = {}

    def close(self) -> None:
        """Nothing is held open."""

    def channels(self) -> list[Channel]:
        """Its columns."""
        return self.columns

    def numbers(self, name: str) -> list[str]:
        """None: a column has no fields."""
        return []

    def obstacles(self) -> list[str]:
        """What has to be mended or named beside the signals."""
        found = [self.fault] if self.fault else []
        if self.stated.time is None and self.stated.sample_rate_hz is None and not self.steps:
            try:
                self._own_time(self.names[0])
            except InputError as error:
                found += error.faults
        return found

    def candidates(self, role: str) -> list[Source]:
        """Columns that are called what the role is."""
        words = ("velocity", "position") if role == "velocity" else (role,)
        return [
            Source(name=name)
            for name in self.names
            if any(is_called(name, word) for word in words)
            and (role == "pretension" or not is_called(name, "pretension"))
        ]

    def is_position(self, source: Source) -> bool:
        """Whether a column is called a position."""
        return is_called(source.name, "position")

    def unit(self, source: Source) -> str:
        """As the row of units has it, else the brackets behind the name."""
        return self.units.get(source.name, "").strip(" []()<>{}") or in_brackets(source.name)

    def described(self, source: Source) -> str:
        """The column."""
        return f"column {shown(source.name)}"

    def read(self, sources: Mapping[str, Source], progress: Progress) -> dict[str, Series]:
        """The signals in one pass over the rows."""
        faults: list[str] = []
        clocks: dict[str, Clock | _Regular] = {}
        for key, source in sources.items():
            faults += (missing := list(self._missing(source)))
            if not missing:
                try:
                    clocks[key] = self._clock(source)
                except InputError as error:
                    faults += error.faults
        if faults:
            raise InputError(list(dict.fromkeys(faults)))
        grown = {key: Growing() for key in sources}
        # Signals of one clock are read together; those of another may have another number of rows.
        for clock in dict.fromkeys(clocks.values()):
            own = {key: source.name for key, source in sources.items() if clocks[key] == clock}
            self._read(clock, own, grown, progress)
        told = [note for clock in dict.fromkeys(clocks.values()) for note in self._told(clock)]
        notes = (*self.notes, *told)
        return {key: replace(samples.done(), notes=notes) for key, samples in grown.items()}

    def _read(
        self,
        clock: Clock | _Regular,
        names: Mapping[str, str],
        grown: Mapping[str, Growing],
        progress: Progress,
    ) -> None:
        """Add the rows of the columns `names` to `grown`, by its keys."""
        columns = () if isinstance(clock, _Regular) else clock
        row, days = 0, Days()
        for chunk in self.chunks(list(dict.fromkeys([*columns, *names.values()])), progress):
            if isinstance(clock, _Regular):
                size = len(next(iter(chunk.values())))
                stamps, known = clock.step.stamps(row, size), np.ones(size, bool)
                row += size
            else:
                stamps, known = self._stamps(columns, chunk)
                if chunk[columns[0]].dtype.kind == "M":
                    stamps[known] = days.since_first(stamps[known])
            for key, name in names.items():
                value = self._numbers(chunk[name], name)
                there = ~np.isnan(value)
                if np.any(there & ~known):
                    where = self._where(columns)
                    raise InputError(f"{where}: a time is missing; fill the column")
                grown[key].time.frombytes(stamps[there].tobytes())
                grown[key].value.frombytes(value[there].tobytes())

    def _clock(self, source: Source) -> Clock | _Regular:
        """The columns of a signal's times, or its sampling interval and number of rows."""
        count = self.columns[self.names.index(source.name)].count
        if text := source.time or self.stated.time:
            return self._named(text)
        if self.stated.sample_rate_hz is not None:
            return _Regular(Step(0, 1.0 / self.stated.sample_rate_hz), count)
        if source.name in self.steps:
            return _Regular(self.steps[source.name], count)
        return self._own_time(source.name)

    def _named(self, text: str) -> Clock:
        """The column `text`, or those whose sum it is, as in `secs+nsecs`."""
        parts = tuple(part.strip() for part in text.split("+"))
        return parts if text not in self.names and set(parts) <= set(self.names) else (text,)

    def _missing(self, source: Source) -> Iterator[str]:
        if source.field is not None:
            yield f"{self._where([source.name])}: a column has no fields; remove 'field'"
        text = source.time or self.stated.time
        for name in dict.fromkeys((source.name, *(self._named(text) if text else ()))):
            if name in self.names:
                continue
            if alike := [other for other in self.names if NUMBERED.sub("", other) == name]:
                yield f"{self._where([name])}: is there {len(alike)} times; name one of {some(alike)}"
            else:
                hint = suggestion(name, self.names) or f"; it has {some(self.names)}"
                yield f"{self.path}: has no column {shown(name)}{hint}"

    @cached_property
    def _clocks(self) -> list[Clock]:
        """What may be the time where nothing is stated."""
        return find_clocks(self.names, self.units, self._first)

    def _no_time(self, clocks: Sequence[Clock]) -> str:
        """What is said where no column is clearly the time."""
        found = [" + ".join(clock) for clock in clocks]
        what = (
            f"columns {some(found)} may all be the time"
            if found
            else "no column is called a time, and none alone increases"
        )
        remedy = f"name it by --time, one of {some(self.names)}, or state the sampling rate by --rate"
        return f"{self.path}: {what}; {remedy}"

    def _own_time(self, name: str) -> Clock:
        """The clock in the group of a signal, or else in one around it; of several of one name the next on its left."""
        near: list[Clock] = []
        for group in groups(name):
            near = near or [clock for clock in self._clocks if groups(clock[0])[0] == group]
        near = near or self._clocks
        if len({NUMBERED.sub("", last_part(clock[0])) for clock in near}) != 1:
            raise InputError(self._no_time(near))
        left = [clock for clock in near if self.names.index(clock[0]) < self.names.index(name)]
        return left[-1] if left else near[0]

    def _told(self, clock: Clock | _Regular) -> Iterator[str]:
        """What a user should know of a time that nothing stated."""
        if isinstance(clock, _Regular):
            return
        if self.stated.time is None and not any(
            is_time(n) or speaks_of_time(n) or n in self.units for n in clock
        ):
            yield f"{self._where(clock)}: is taken for the time, as the only column that increases"
        for name in clock:
            if self._scales.get(name, 1.0) < 1.0:
                yield f"{self._where([name])}: times of that size are read in units of {self._scales[name]:g} s"

    def _first(self, clock: Clock) -> Stamps | None:
        """The times of the first chunk of rows; None where the columns hold none."""
        try:
            chunk = next(iter(self.chunks(list(clock), lambda done, total: None)), None)
            return self._stamps(clock, chunk) if chunk is not None else None
        except InputError:
            return None

    def _stamps(self, columns: Sequence[str], chunk: Chunk) -> Stamps:
        """The sum of columns of times, ns, and where all of them are known."""
        scales = [self._scale(name, chunk[name], len(columns) == 1) for name in columns]
        parts = [
            nanoseconds(chunk[name], scale, self._where([name]))
            for name, scale in zip(columns, scales, strict=True)
        ]
        known = np.logical_and.reduce([known for _, known in parts])
        return np.sum([time for time, _ in parts], axis=0, dtype=np.int64), known

    def _scale(self, name: str, values: NDArray[np.generic], alone: bool) -> float:
        """Seconds a unit of a time column: as stated, by its name or the row of units, else by its first value."""
        if self.stated.time_scale is not None and alone:
            return self.stated.time_scale
        if (unit := unit_of(name) or is_unit(self.units.get(name, ""))) is not None:
            return unit
        if name not in self._scales:
            if (usual := usual_scale(values)) is None:
                return 1.0
            self._scales[name] = usual
        return self._scales[name]

    def _where(self, names: Sequence[str]) -> str:
        return f"{self.path} column {' + '.join(map(shown, names))}"

    def _numbers(self, values: NDArray[np.generic], name: str) -> Array:
        if values.dtype.kind not in "fiub" or values.ndim != 1:
            raise InputError(f"{self._where([name])}: holds no numbers; name another column")
        return values.astype(np.float64)

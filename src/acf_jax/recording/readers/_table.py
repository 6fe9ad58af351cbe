"""What tables of every kind share: columns by name, a column of times, rows without a value."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from acf_jax.errors import InputError, shown, suggestion
from acf_jax.recording.mapping import Source
from acf_jax.recording.readers._guard import some
from acf_jax.recording.series import Array, Channel, Growing, Nanoseconds, Progress, Series

Chunk = Mapping[str, NDArray[np.generic]]
# The chunks of rows of some columns, in order.
Chunks = Callable[[Sequence[str], Progress], Iterator[Chunk]]

ROLES = {
    "force": r"force|fz|f_z|load",
    "velocity": r"velocity|speed|position",
    "pretension": r"pretension|preload",
}
TIMES = r"time|t|timestamp|stamp|clock"
UNITS = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_UNIT = re.compile(rf"[_ \[(/]({'|'.join(UNITS)})[\])]?")


class Table:
    """A recording in columns; a row of which a value is missing is no sample of that signal."""

    def __init__(
        self,
        path: Path,
        columns: Sequence[Channel],
        chunks: Chunks,
        time: str | None,
        time_scale: float | None,
    ):
        self.path, self.columns, self.chunks = path, list(columns), chunks
        self.names = [column.name for column in columns]
        self.time = self._time_column() if time is None else time
        self.time_scale = time_scale

    def close(self) -> None:
        """Nothing is held open."""

    def channels(self) -> list[Channel]:
        """Its columns."""
        return self.columns

    def candidates(self, role: str) -> list[Source]:
        """Columns that are called what the role is."""
        words = re.compile(rf"(?<![a-z])({ROLES[role]})(?![a-z])")
        taken = re.compile(rf"(?<![a-z])({ROLES['pretension']})(?![a-z])")
        return [
            Source(name=name)
            for name in self.names
            if words.search(name.lower()) and (role == "pretension" or not taken.search(name.lower()))
        ]

    def is_position(self, source: Source) -> bool:
        """Whether a column is called a position."""
        return re.search(r"(?<![a-z])position(?![a-z])", source.name.lower()) is not None

    def described(self, source: Source) -> str:
        """The column."""
        return f"column {shown(source.name)}"

    def read(self, sources: Mapping[str, Source], progress: Progress) -> dict[str, Series]:
        """The signals in one pass over the rows."""
        faults = [fault for source in sources.values() for fault in self._missing(source)]
        if faults:
            raise InputError(faults)
        grown = {key: Growing() for key in sources}
        # Signals of one time column are read together; those of another may have another number of rows.
        for time in dict.fromkeys(source.time or self.time for source in sources.values()):
            own = {key: source.name for key, source in sources.items() if (source.time or self.time) == time}
            self._read(time, own, grown, progress)
        return {key: samples.done() for key, samples in grown.items()}

    def _read(
        self, time: str, names: Mapping[str, str], grown: Mapping[str, Growing], progress: Progress
    ) -> None:
        """Add the rows of the columns `names` to `grown`, by its keys."""
        scale = self._scale(time)
        for chunk in self.chunks(list(dict.fromkeys([time, *names.values()])), progress):
            stamps, known = self._nanoseconds(chunk[time], scale, time)
            for key, name in names.items():
                value = self._numbers(chunk[name], name)
                there = ~np.isnan(value)
                if np.any(there & ~known):
                    raise InputError(f"{self.path} column {shown(time)}: a time is missing; fill the column")
                grown[key].time.frombytes(stamps[there].tobytes())
                grown[key].value.frombytes(value[there].tobytes())

    def _time_column(self) -> str:
        """The column that is called a time."""
        pattern = re.compile(rf"({TIMES})({_UNIT.pattern})?", re.IGNORECASE)
        found = [name for name in self.names if pattern.fullmatch(name.strip())]
        if len(found) == 1:
            return found[0]
        what = f"columns {some(found)} may all be the time" if found else "no column is called a time"
        raise InputError(f"{self.path}: {what}; name it by --time, one of {some(self.names)}")

    def _missing(self, source: Source) -> Iterator[str]:
        if source.field is not None:
            yield f"{self.path} column {shown(source.name)}: a column has no fields; remove 'field'"
        for name in dict.fromkeys((source.name, source.time or self.time)):
            if name not in self.names:
                hint = suggestion(name, self.names) or f"; it has {some(self.names)}"
                yield f"{self.path}: has no column {shown(name)}{hint}"

    def _scale(self, name: str) -> float:
        """Seconds a unit of a time column: as stated, else by the unit that ends its name."""
        if self.time_scale is not None:
            return self.time_scale
        unit = _UNIT.search(name.lower())
        return UNITS[unit[1]] if unit and unit.end() == len(name) else 1.0

    def _nanoseconds(
        self, values: NDArray[np.generic], scale: float, name: str
    ) -> tuple[Nanoseconds, NDArray[np.bool_]]:
        """Times in ns, and where they are known."""
        if values.dtype.kind == "M":
            known = ~np.isnat(values)
            return values.astype("datetime64[ns]").astype(np.int64), known
        factor = round(1e9 * scale)
        if values.dtype.kind in "iu" and factor >= 1 and abs(factor - 1e9 * scale) < 1e-6:
            if values.size and int(np.abs(values).max()) > 2**62 // factor:
                raise InputError(f"{self.path} column {shown(name)}: {self._unit_fault()}")
            return values.astype(np.int64) * factor, np.ones(values.size, bool)
        with np.errstate(over="ignore"):
            time = self._numbers(values, name) * (1e9 * scale)
        known = ~np.isnan(time)
        if np.any(np.abs(time[known]) > 2.0**62):
            raise InputError(f"{self.path} column {shown(name)}: {self._unit_fault()}")
        return np.rint(np.where(known, time, 0.0)).astype(np.int64), known

    def _unit_fault(self) -> str:
        return (
            "holds times beyond a century; state the seconds in its unit in the --mapping file"
            " (time_scale: 1.0e-9 for ns)"
        )

    def _numbers(self, values: NDArray[np.generic], name: str) -> Array:
        if values.dtype.kind not in "fiub" or values.ndim != 1:
            raise InputError(f"{self.path} column {shown(name)}: holds no numbers; name another column")
        return values.astype(np.float64)

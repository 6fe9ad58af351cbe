"""Arrays by name as a table: those of one length are the rows, a matrix is as many columns as it is narrow."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from acf_jax.errors import InputError, shown
from acf_jax.recording.mapping import Mapping as Stated
from acf_jax.recording.readers._bounds import check_rows
from acf_jax.recording.readers._guard import Faults, border
from acf_jax.recording.readers._table import Chunk, Table, unique
from acf_jax.recording.series import Channel, Progress

ROWS = 1_000_000  # of a chunk
_WIDEST = 100  # columns of a matrix
Index = tuple[slice | int, ...]


@dataclass(frozen=True)
class Stored:
    """An array that is not read yet."""

    name: str
    shape: tuple[int, ...]
    type: str
    load: Callable[[Index], NDArray[np.generic]]  # a part of it


def part_of(load: Callable[[str], NDArray[np.generic]], name: str) -> Callable[[Index], NDArray[np.generic]]:
    """What takes a part of an array that can be loaded only as a whole."""
    return lambda index: load(name)[index]


def array_table(
    path: Path,
    arrays: Sequence[Stored],
    stated: Stated,
    faults: Faults,
    remedy: str,
    *,
    units: Mapping[str, str] | None = None,
    fault: str | None = None,
) -> Table:
    """The arrays of a file as columns: a vector by its name, those of a matrix as NAME[0], NAME[1].

    **Arguments:** `faults`, `remedy`: of loading, for `border`. `units` by the names of the arrays.
    `fault`: what is said where a signal is not found.
    """
    parts = [(stored, *part) for stored in arrays for part in _columns(stored)]
    names = unique([f"{stored.name}{suffix}" for stored, suffix, _ in parts])
    known = dict(zip(names, ((stored, index) for stored, _, index in parts), strict=True))

    def load(name: str) -> NDArray[np.generic]:
        stored, index = known[name]
        check_rows(path, max(stored.shape, default=0))
        with border(path, faults, remedy):
            return stored.load(index)

    def chunks(wanted: Sequence[str], progress: Progress) -> Iterator[Chunk]:
        columns = {name: load(name) for name in wanted}
        shapes = {name: column.shape for name, column in columns.items()}
        if len(set(shapes.values())) > 1 or any(len(shape) != 1 for shape in shapes.values()):
            listed = ", ".join(f"{shown(name)} {shape}" for name, shape in shapes.items())
            raise InputError(
                f"{path}: the arrays {listed} must be of one dimension and length; cut them to it"
            )
        size = next(iter(shapes.values()))[0]
        for first in range(0, max(size, 1), ROWS):
            yield {name: column[first : first + ROWS] for name, column in columns.items()}
            progress(min(first + ROWS, size), size)

    channels = [Channel(name, known[name][0].type, max(known[name][0].shape, default=1)) for name in names]
    by_column = {name: units[known[name][0].name] for name in names if units and known[name][0].name in units}
    return Table(path, channels, chunks, stated, units=by_column, fault=fault)


def _columns(stored: Stored) -> Iterator[tuple[str, Index]]:
    """The columns of an array: what stands behind its name, and their place; all of it where it is no table."""
    long = [axis for axis, size in enumerate(stored.shape) if size != 1]
    every: list[slice | int] = [slice(None) if axis in long else 0 for axis in range(len(stored.shape))]
    if len(long) != 2 or min(stored.shape[axis] for axis in long) > _WIDEST:
        if len(long) == 0 and every:
            every[0] = slice(None)  # a single row
        yield "", tuple(every)
        return
    narrow = min(long, key=lambda axis: stored.shape[axis])
    for i in range(stored.shape[narrow]):
        yield f"[{i}]", tuple(i if axis == narrow else part for axis, part in enumerate(every))

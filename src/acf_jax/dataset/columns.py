"""Long CSV files of numbers, read part by part into columns."""

import io
import math
import warnings
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acf_jax.dataset.table import (
    LARGEST,
    LONGEST_ROW,
    Record,
    Table,
    noting_faults,
    opened,
    read_header,
    records_of,
    whole_rows,
)
from acf_jax.errors import InputError

_MOST_ROWS = 20_000_000
_BLOCK = 1_000_000  # characters that are looked at together
_CHUNK = 10_000  # and rows


class Columns(NamedTuple):
    """The numbers of a table whose rows are not kept as text."""

    lines: NDArray[np.int64]  # (N,) each row's line in the file
    values: NDArray[np.float64]  # (N, columns)


def read_columns(path: Path, columns: Sequence[str]) -> tuple[Table, Columns]:
    """Read columns of numbers from a long CSV file; the rest is as in `read_table`, but for its `rows`.

    Every number is finite where the table has no faults.
    """
    table, parts = Table(path), [Columns(np.empty(0, np.int64), np.empty((0, len(columns))))]
    with noting_faults(table):
        file = opened(path)
        line = read_header(table, records_of(path, file), columns)
        if all(column in table.columns for column in columns):
            places = [table.columns.index(column) for column in columns]
            count = 0
            for part in _parts(table, file, line, places):
                parts.append(part)
                count += part.lines.size
                if count > _MOST_ROWS:
                    raise InputError(f"{path}: holds more than {_MOST_ROWS:,} rows; cut it to what is needed")
    return table, Columns(*map(np.concatenate, zip(*parts, strict=True)))


def _parts(table: Table, file: io.TextIOWrapper, line: int, places: list[int]) -> Iterator[Columns]:
    """The numbers behind so many lines of a file, part by part: all at once where rows hold nothing but numbers."""
    while not table.is_hopeless:
        begin = file.tell()
        block = file.read(_BLOCK) + file.readline(LONGEST_ROW + 1)
        if not block:
            return
        if '"' in block:  # a cell may go on beyond the block
            file.seek(begin)
            records = records_of(table.path, file, line)
            while (chunk := list(islice(records, _CHUNK))) and not table.is_hopeless:
                yield _numbers(table, chunk, places)
            return
        rows = block.removesuffix("\n").split("\n")
        values = _plain_numbers(rows, len(table.columns))
        if values is None:
            yield _numbers(table, records_of(table.path, io.StringIO(block), line), places)
        else:
            yield Columns(np.arange(line + 1, line + 1 + len(rows)), values[:, places])
        line += len(rows)


def _plain_numbers(rows: list[str], width: int) -> NDArray[np.float64] | None:
    """All cells of rows without quotes; None where any is no number, or any row is blank or has another width."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of rows that are all blank
            values = np.loadtxt(rows, delimiter=",", comments=None, ndmin=2)
    except ValueError:
        return None
    return values if values.shape == (len(rows), width) and (np.abs(values) < LARGEST).all() else None


def _numbers(table: Table, records: Iterable[Record], places: list[int]) -> Columns:
    """The numbers of any rows; faults go to the table."""
    lines, values = [], []
    for number, cells in whole_rows(table, records):
        found = [table.value(cells[i], table.columns[i], f"row {number}") for i in places]
        lines.append(number)
        values.append([math.nan if value is None else value for value in found])
    return Columns(np.array(lines, np.int64), np.array(values, float).reshape(len(lines), len(places)))

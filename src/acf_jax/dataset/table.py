"""CSV files as rows of text or as columns of numbers, with every fault of their form collected."""

import csv
import io
import math
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acf_jax.errors import InputError, shown, suggestion
from acf_jax.files import read_bytes

_LARGEST = 1e100  # beyond it no measurement lies, and squares overflow
_SHOWN = 8  # faults shown of one file; a wrong column would fill the screen otherwise
_MOST_FAULTS = 1000  # after which a file is not read on
_MOST_COLUMNS = 1000
_MOST_CELLS = 1_000_000  # of a table whose cells are kept as text: a few hundred megabytes of memory
_LONGEST_ROW = 1_000_000  # characters; its cells take up to fifty times as much memory
_MOST_ROWS = 20_000_000  # of a table of numbers
_BLOCK = 1_000_000  # characters that are looked at together
_CHUNK = 10_000  # and rows

Record = tuple[int, list[str]]  # line in the file, and cells


@dataclass(frozen=True)
class Row:
    """One line of a table: its line number in the file and its cells by column."""

    number: int
    cells: dict[str, str]


@dataclass
class Table:
    """What was read of a CSV file, and the faults met while it is looked at."""

    path: Path
    columns: tuple[str, ...] = ()
    rows: list[Row] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)

    @property
    def is_hopeless(self) -> bool:
        """Whether there are so many faults that no more need to be found."""
        return len(self.faults) >= _MOST_FAULTS

    def fault(self, where: str, what: str) -> None:
        """Note a fault at `where` (a row, a column; empty for the file)."""
        self.faults.append(f"{self.path}{' ' + where if where else ''}: {what}")

    def number(self, row: Row, column: str, where: str = "") -> float | None:
        """The finite number in a cell; None, and a fault, when there is none."""
        return self.value(row.cells[column], column, where or f"row {row.number}")

    def value(self, text: str, column: str, where: str) -> float | None:
        """The same of a cell's text."""
        value = _value(text)
        if value is not None and abs(value) < _LARGEST:
            return value
        what = "is empty" if not text else f"is {shown(text)}, not a number"
        if value is not None:
            size = "larger than any measurement" if math.isfinite(value) else "not a finite number"
            what = f"is {shown(text)}, {size}"
        self.fault(where, f"{column} {what}; give a number such as 1.5e-3")
        return None

    def shown_faults(self) -> list[str]:
        """The first faults in full, and how many more there are."""
        rest = len(self.faults) - _SHOWN
        count = f"{'at least ' * self.is_hopeless}{rest} more faults"
        more = [f"{self.path}: {count} of this file are not shown; correct these first"]
        return self.faults[:_SHOWN] + (more if rest > 0 else [])


class Columns(NamedTuple):
    """The numbers of a table whose rows are not kept as text."""

    lines: NDArray[np.int64]  # (N,) each row's line in the file
    values: NDArray[np.float64]  # (N, columns)


def read_table(path: Path, required: Sequence[str]) -> Table:
    """Read a CSV file with a header; faults of its form are in the result.

    Blank lines and empty columns at the right are skipped, cells lose the blanks around them.
    """
    table = Table(path)
    with _noting_faults(table):
        records = _records(path, _opened(path))
        _read_header(table, records, required)
        count = 0
        for number, cells in _whole_rows(table, records):
            count += len(cells)
            if count > _MOST_CELLS:
                raise InputError(
                    f"{path}: holds more than {_MOST_CELLS:,} cells; split it into several tables"
                )
            table.rows.append(Row(number, dict(zip(table.columns, cells, strict=True))))
    return table


def read_columns(path: Path, columns: Sequence[str]) -> tuple[Table, Columns]:
    """Read columns of numbers from a long CSV file; the rest is as in `read_table`, but for its `rows`.

    Every number is finite where the table has no faults.
    """
    table, parts = Table(path), [Columns(np.empty(0, np.int64), np.empty((0, len(columns))))]
    with _noting_faults(table):
        file = _opened(path)
        line = _read_header(table, _records(path, file), columns)
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
        block = file.read(_BLOCK) + file.readline(_LONGEST_ROW + 1)
        if not block:
            return
        if '"' in block:  # a cell may go on beyond the block
            file.seek(begin)
            records = _records(table.path, file, line)
            while (chunk := list(islice(records, _CHUNK))) and not table.is_hopeless:
                yield _numbers(table, chunk, places)
            return
        rows = block.removesuffix("\n").split("\n")
        values = _plain_numbers(rows, len(table.columns))
        if values is None:
            yield _numbers(table, _records(table.path, io.StringIO(block), line), places)
        else:
            yield Columns(np.arange(line + 1, line + 1 + len(rows)), values[:, places])
        line += len(rows)


def _value(text: str) -> float | None:
    """The number that a text writes in decimal digits."""
    try:
        return float(text) if text.isascii() and "_" not in text else None
    except ValueError:
        return None


def _plain_numbers(rows: list[str], width: int) -> NDArray[np.float64] | None:
    """All cells of rows without quotes; None where any is no number, or any row is blank or has another width."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of rows that are all blank
            values = np.loadtxt(rows, delimiter=",", comments=None, ndmin=2)
    except ValueError:
        return None
    return values if values.shape == (len(rows), width) and (np.abs(values) < _LARGEST).all() else None


def _numbers(table: Table, records: Iterable[Record], places: list[int]) -> Columns:
    """The numbers of any rows; faults go to the table."""
    lines, values = [], []
    for number, cells in _whole_rows(table, records):
        found = [table.value(cells[i], table.columns[i], f"row {number}") for i in places]
        lines.append(number)
        values.append([math.nan if value is None else value for value in found])
    return Columns(np.array(lines, np.int64), np.array(values, float).reshape(len(lines), len(places)))


@contextmanager
def _noting_faults(table: Table) -> Iterator[None]:
    """What cannot be read at all becomes a fault of the table."""
    try:
        yield
    except InputError as error:
        table.faults.extend(error.faults)
    except csv.Error as error:
        table.fault("", f"is not a CSV table ({error}); save it as comma-separated text")
    except UnicodeDecodeError as error:
        table.fault("", f"is not UTF-8 text ({error.reason}); save it as UTF-8")


def _read_header(table: Table, records: Iterator[Record], required: Sequence[str]) -> int:
    """Take the header, whatever blank lines are before it; the number of its line."""
    line, header = next(
        ((number, found) for number, cells in records if (found := _stripped(cells))), (0, [])
    )
    if not header:
        raise InputError(f"{table.path}: is empty; its first line must be {','.join(required)}")
    if len(header) > _MOST_COLUMNS:
        raise InputError(
            f"{table.path}: has more than {_MOST_COLUMNS:,} columns; remove those that are not needed"
        )
    table.columns = tuple(header)
    for column in required:
        if column not in header:
            separated = any(c in "".join(header) for c in ";\t") and len(header) == 1
            hint = "; separate cells by commas" if separated else suggestion(column, header)
            table.fault("", f"column '{column}' is missing{hint or '; add it to the first line'}")
    for column, count in Counter(header).items():
        if column and count > 1:
            table.fault("", f"column {shown(column)} is there twice; remove one")
    return line


def _whole_rows(table: Table, records: Iterable[Record]) -> Iterator[Record]:
    """The rows that are not blank and have a cell for each column, stripped; others are faults of the table."""
    width = len(table.columns)
    for number, cells in records:
        cells = _stripped(cells, width)
        if not cells or table.is_hopeless:
            continue
        if len(cells) == width:
            yield number, cells
            continue
        remedy = "fill the row; the file may be cut off"
        if len(cells) > width:
            remedy = "write decimals with a point and quote text that holds commas"
        table.fault(f"row {number}", f"has {len(cells)} cells, not {width}; {remedy}")


def _stripped(cells: list[str], width: int = 0) -> list[str]:
    """Cells without the blanks around them, and without empty ones at the right beyond `width`; none of a blank row."""
    cells = [cell.strip() for cell in cells]
    if not any(cells):
        return []
    while len(cells) > width and not cells[-1]:
        cells.pop()
    return cells


def _opened(path: Path) -> io.TextIOWrapper:
    """A file's text, its line ends as Python's."""
    return io.TextIOWrapper(io.BytesIO(read_bytes(path)), "utf-8-sig")


def _records(path: Path, file: io.TextIOBase, before: int = 0) -> Iterator[Record]:
    """The records of a text behind so many lines; `InputError` for one that is too long to be a row."""
    length = 0  # of the record that is being read, which may span lines

    def lines() -> Iterator[str]:
        nonlocal length
        while line := file.readline(_LONGEST_ROW + 1 - length):
            length += len(line)
            if length > _LONGEST_ROW:
                where = f"{path} row {before + reader.line_num + 1}"
                raise InputError(f"{where}: is longer than {_LONGEST_ROW:,} characters; write a row a line")
            yield line

    reader = csv.reader(lines(), strict=True)
    for cells in reader:
        length = 0
        if cells:
            yield before + reader.line_num, cells

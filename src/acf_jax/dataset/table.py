"""CSV files as rows of text, with every fault of their form collected."""

import csv
import io
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from acf_jax.errors import InputError, shown, suggestion
from acf_jax.files import read_bytes

LARGEST = 1e100  # beyond it no measurement lies, and squares overflow
_SHOWN = 8  # faults shown of one file; a wrong column would fill the screen otherwise
_MOST_FAULTS = 1000  # after which a file is not read on
_MOST_COLUMNS = 1000
_MOST_CELLS = 1_000_000  # of a table whose cells are kept as text: a few hundred megabytes of memory
LONGEST_ROW = 1_000_000  # characters; its cells take up to fifty times as much memory

Record = tuple[int, list[str]]  # line in the file, where it begins, and cells


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
        if value is not None and abs(value) < LARGEST:
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


def read_table(path: Path, required: Sequence[str]) -> Table:
    """Read a CSV file with a header; faults of its form are in the result.

    Blank lines and empty columns at the right are skipped, cells lose the blanks around them.
    """
    table = Table(path)
    with noting_faults(table):
        records = records_of(path, opened(path))
        read_header(table, records, required)
        count = 0
        for number, cells in whole_rows(table, records):
            count += len(cells)
            if count > _MOST_CELLS:
                raise InputError(
                    f"{path}: holds more than {_MOST_CELLS:,} cells; split it into several tables"
                )
            table.rows.append(Row(number, dict(zip(table.columns, cells, strict=True))))
    return table


def _value(text: str) -> float | None:
    """The number that a text writes in decimal digits."""
    try:
        return float(text) if text.isascii() and "_" not in text else None
    except ValueError:
        return None


@contextmanager
def noting_faults(table: Table) -> Iterator[None]:
    """What cannot be read at all becomes a fault of the table."""
    try:
        yield
    except InputError as error:
        table.faults.extend(error.faults)
    except csv.Error as error:
        table.fault("", f"is not a CSV table ({error}); save it as comma-separated text")
    except UnicodeDecodeError as error:
        table.fault("", f"is not UTF-8 text ({error.reason}); save it as UTF-8")


def read_header(table: Table, records: Iterator[Record], required: Sequence[str]) -> int:
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


def whole_rows(table: Table, records: Iterable[Record]) -> Iterator[Record]:
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


def opened(path: Path) -> io.TextIOWrapper:
    """A file's text, its line ends as Python's."""
    return io.TextIOWrapper(io.BytesIO(read_bytes(path)), "utf-8-sig")


def records_of(path: Path, file: io.TextIOBase, before: int = 0) -> Iterator[Record]:
    """The records of a text behind so many lines, with the line where each begins.

    **Raises:** `InputError` for one that is too long to be a row.
    """
    length = 0  # of the record that is being read, which may span lines

    def lines() -> Iterator[str]:
        nonlocal length
        while line := file.readline(LONGEST_ROW + 1 - length):
            length += len(line)
            if length > LONGEST_ROW:
                where = f"{path} row {before + reader.line_num + 1}"
                raise InputError(f"{where}: is longer than {LONGEST_ROW:,} characters; write a row a line")
            yield line

    reader = csv.reader(lines(), strict=True)
    begin = 1
    for cells in reader:
        if cells:
            yield before + begin, cells
        length, begin = 0, reader.line_num + 1

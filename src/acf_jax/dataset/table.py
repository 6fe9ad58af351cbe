"""CSV files as rows of text, with every fault of their form collected."""

import csv
import io
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from acf_jax.errors import InputError, shown, suggestion
from acf_jax.files import read_text

_LARGEST = 1e100  # beyond it no measurement lies, and squares overflow
_SHOWN = 8  # faults shown of one file; a wrong column would fill the screen otherwise


@dataclass(frozen=True)
class Row:
    """One line of a table: its line number in the file and its cells by column."""

    number: int
    cells: dict[str, str]


@dataclass
class Table:
    """The rows of a CSV file, and the faults met while they are read."""

    path: Path
    columns: tuple[str, ...] = ()
    rows: list[Row] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)

    def fault(self, where: str, what: str) -> None:
        """Note a fault at `where` (a row, a column; empty for the file)."""
        self.faults.append(f"{self.path}{' ' + where if where else ''}: {what}")

    def number(self, row: Row, column: str, where: str = "") -> float | None:
        """The finite number in a cell; None, and a fault, when there is none."""
        text = row.cells[column]
        try:
            value = math.nan if "_" in text else float(text)
        except ValueError:
            value = math.nan
            what = "is empty" if not text else f"is {shown(text)}, not a number"
        else:
            too_large = "larger than any measurement" if math.isfinite(value) else "not a finite number"
            what = f"is {shown(text)}, {too_large}"
        if abs(value) < _LARGEST:
            return value
        self.fault(where or f"row {row.number}", f"{column} {what}; give a number such as 1.5e-3")
        return None

    def shown_faults(self) -> list[str]:
        """The first faults in full, and how many more there are."""
        rest = len(self.faults) - _SHOWN
        more = [f"{self.path}: {rest} more faults of this file are not shown; correct these first"]
        return self.faults[:_SHOWN] + (more if rest > 0 else [])


def read_table(path: Path, required: Sequence[str]) -> Table:
    """Read a CSV file with a header; faults of its form are in the result.

    Blank lines and empty columns at the right are skipped, cells lose the blanks around them.
    """
    table = Table(path)
    try:
        _fill(table, read_text(path), required)
    except InputError as error:
        table.faults.extend(error.faults)
    except csv.Error as error:
        table.fault("", f"is not a CSV table ({error}); save it as comma-separated text")
    return table


def _fill(table: Table, text: str, required: Sequence[str]) -> None:
    records = _records(text)
    _, header = next(records, (0, []))
    if not header:
        return table.fault("", f"is empty; its first line must be {','.join(required)}")
    table.columns = tuple(header)
    for column in required:
        if column not in header:
            separated = any(c in "".join(header) for c in ";\t") and len(header) == 1
            hint = "; separate cells by commas" if separated else suggestion(column, header)
            table.fault("", f"column '{column}' is missing{hint or '; add it to the first line'}")
    for column in dict.fromkeys(c for c in header if c and header.count(c) > 1):
        table.fault("", f"column {shown(column)} is there twice; remove one")
    for number, cells in records:
        if len(cells) > len(header):
            remedy = "write decimals with a point and quote text that holds commas"
            table.fault(f"row {number}", f"has {len(cells)} cells, not {len(header)}; {remedy}")
        elif len(cells) < len(header):
            remedy = "fill the row; the file may be cut off"
            table.fault(f"row {number}", f"has {len(cells)} cells, not {len(header)}; {remedy}")
        else:
            table.rows.append(Row(number, dict(zip(header, cells, strict=True))))


def _records(text: str) -> Iterator[tuple[int, list[str]]]:
    """Line number and stripped cells of each line that is not blank."""
    width = None
    lines = csv.reader(io.StringIO(text), strict=True)
    for cells in lines:
        cells = [cell.strip() for cell in cells]
        if not any(cells):
            continue
        if width is None:
            while cells and not cells[-1]:
                cells.pop()
            width = len(cells)
        else:
            while len(cells) > width and not cells[-1]:
                cells.pop()
        yield lines.line_num, cells

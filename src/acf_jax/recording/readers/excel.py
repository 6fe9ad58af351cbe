"""Excel sheets, through openpyxl; a table is found in a sheet as in a text."""

import struct
import warnings
import zipfile
import zlib
from collections.abc import Generator, Iterator, Sequence
from contextlib import closing, contextmanager
from datetime import datetime, time, timedelta
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from acf_jax.errors import InputError, shown
from acf_jax.recording.mapping import Mapping
from acf_jax.recording.readers._bounds import check_rows, check_unpacked
from acf_jax.recording.readers._guard import Faults, border, need, within
from acf_jax.recording.readers._layout import LOOKED_AT, find_header, trimmed
from acf_jax.recording.readers._table import Chunk, Table, unique
from acf_jax.recording.readers._values import is_missing, is_stamp, stamps
from acf_jax.recording.series import Channel, Progress

KIND = "an Excel file (.xlsx, .xlsm)"
ROWS = 5_000  # of a chunk
_WIDEST = 1000  # columns
_FAULTS: Faults = (OSError, EOFError, ValueError, LookupError, TypeError, AttributeError, ArithmeticError,
                   RuntimeError, SyntaxError, MemoryError, zipfile.BadZipFile, zlib.error, struct.error)  # fmt: skip
_REMEDY = "open it in Excel and save it again as .xlsx or as .csv"
Cells = tuple[Any, ...]


class _Sheet(NamedTuple):
    """A table within a sheet."""

    title: str
    names: list[str]
    units: list[str]
    first: int  # row of its first numbers
    note: str | None


def recognises(path: Path) -> bool:
    """A file of one of the suffixes, that of old Excel files among them."""
    return path.is_file() and path.suffix.lower() in (".xlsx", ".xlsm", ".xls", ".xlsb")


def open_recording(path: Path, stated: Mapping) -> Table:
    """The columns of the sheet that holds numbers; of several such sheets SHEET/COLUMN."""
    if path.suffix.lower() not in (".xlsx", ".xlsm"):
        raise InputError(
            f"{path}: is of a kind that is not read; open it in Excel and save it as .xlsx or .csv"
        )
    need("openpyxl", "excel", f"{path}: reading Excel")
    with _workbook(path) as book, border(path, _FAULTS, _REMEDY):
        sheets = [found for sheet in book.worksheets if (found := _table_in(path, sheet))]
    if not sheets:
        raise InputError(f"{path}: holds no sheet with columns of numbers; {_REMEDY}")
    prefix = len(sheets) > 1
    names = unique([f"{sheet.title}/{name}" if prefix else name for sheet in sheets for name in sheet.names])
    places = [(sheet, place) for sheet in sheets for place in range(len(sheet.names))]
    units = {
        name: sheet.units[i] for name, (sheet, i) in zip(names, places, strict=True) if i < len(sheet.units)
    }

    def chunks(wanted: Sequence[str], progress: Progress) -> Iterator[Chunk]:
        own = [places[names.index(name)] for name in wanted]
        titles = {sheet.title for sheet, _ in own}
        if len(titles) > 1:
            raise InputError(
                f"{path}: {', '.join(map(shown, wanted))} are on several sheets; name a time of each"
            )
        sheet, done = own[0][0], 0
        with _workbook(path) as book, closing(_rows(book[sheet.title], sheet.first)) as opened:
            rows = within(opened, path, _FAULTS, _REMEDY)
            while block := list(islice(rows, ROWS)):
                if all(cell is None for row in block for cell in row):
                    return  # a sheet may have a million empty rows
                columns = [[row[place] if place < len(row) else None for row in block] for _, place in own]
                where = f"{path} column"
                yield {n: _values(c, f"{where} {shown(n)}") for n, c in zip(wanted, columns, strict=True)}
                done += len(block)
                check_rows(path, done)
                progress(done, 0)

    notes = [sheet.note for sheet in sheets if sheet.note]
    return Table(path, [Channel(name, "column") for name in names], chunks, stated, units=units, notes=notes)


@contextmanager
def _workbook(path: Path) -> Iterator[Any]:
    """The open file, the size of its parts checked."""
    from openpyxl import load_workbook

    with border(path, _FAULTS, _REMEDY), zipfile.ZipFile(path) as file:
        check_unpacked(path, sum(member.file_size for member in file.infolist()))
    with warnings.catch_warnings(), path.open("rb") as opened:
        warnings.simplefilter("ignore")  # of styles and rules, which hold no data
        with border(path, _FAULTS, _REMEDY):
            book = load_workbook(opened, read_only=True, data_only=True)
        yield book


def _rows(sheet: Any, first: int = 0) -> Generator[Cells, None, None]:
    """The rows of a sheet from row `first` on; what openpyxl holds open is closed with it."""
    with closing(sheet.iter_rows(max_col=_WIDEST, values_only=True)) as rows:
        yield from islice(rows, first, None)


def _table_in(path: Path, sheet: Any) -> _Sheet | None:
    """The table of a sheet, or None where it has no rows of numbers."""
    with closing(_rows(sheet)) as opened:
        rows = _text(list(islice(opened, LOOKED_AT)))
    header = find_header(rows, partial(_named, rows))
    if header is None:
        return None
    names = header.names or [""] * header.cells
    units, note = [], None
    if header.units is not None:
        units = rows[header.units]
        note = f"{path} sheet {shown(sheet.title)} row {header.units + 1}: is taken for a row of units"
    return _Sheet(sheet.title, names, units, header.first, note)


def _text(rows: Sequence[Cells]) -> list[list[str]]:
    """Cells as text, all rows as wide as the widest."""
    width = max(map(len, rows), default=0)
    return [
        ["" if cell is None else str(cell).strip() for cell in (*row, *[None] * (width - len(row)))]
        for row in rows
    ]


def _named(rows: Sequence[list[str]], i: int, low: int, high: int) -> list[str] | None:
    cells = trimmed(rows[i])
    return cells if low <= len(cells) <= high else None


def _values(cells: Sequence[Any], where: str) -> NDArray[np.generic]:
    """Numbers, NaN for empty cells; dates where the first filled cell is one, or times of day."""
    first = next((cell for cell in cells if not _is_missing(cell)), None)
    if isinstance(first, datetime):
        return np.array([cell if isinstance(cell, datetime) else None for cell in cells], "datetime64[us]")
    is_of_day = first is not None and all(isinstance(cell, time) for cell in cells if not _is_missing(cell))
    try:
        if is_of_day or (isinstance(first, str) and is_stamp(first)):
            return stamps(["" if cell is None else str(cell) for cell in cells])
        return np.array([_number(cell) for cell in cells])
    except (ValueError, TypeError):
        raise InputError(f"{where}: holds no numbers; name another column, or correct its cells") from None


def _is_missing(cell: Any) -> bool:
    return cell is None or (isinstance(cell, str) and is_missing(cell))


def _number(cell: Any) -> float:
    if _is_missing(cell):
        return float("nan")
    if isinstance(cell, time):
        return cell.hour * 3600.0 + cell.minute * 60.0 + cell.second + 1e-6 * cell.microsecond
    if isinstance(cell, timedelta):
        return cell.total_seconds()
    return float(cell.replace(",", ".") if isinstance(cell, str) else cell)

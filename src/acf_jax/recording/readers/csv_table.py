"""CSV text with a header: commas, semicolons or tabs, decimal commas where they cannot be separators."""

import csv
import re
from collections import deque
from collections.abc import Iterator, Sequence
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING, TextIO, TypeVar

import numpy as np
from numpy.typing import NDArray

from acf_jax.errors import InputError, shown
from acf_jax.recording.readers._guard import border
from acf_jax.recording.readers._table import Chunk, Table
from acf_jax.recording.series import Channel, Progress

KIND = "a CSV table (.csv, .tsv, .txt)"
SUFFIXES = (".csv", ".tsv", ".txt")
ROWS = 50_000  # of a chunk
LONGEST = 1_000_000  # characters of a line
SHOWN = 8  # faults shown
_DAY = re.compile(r"\s*\d{4}-\d\d-\d\d")
_ANY_DATE = re.compile(r"\s*(\d{1,4}[:/-]\d|\d{1,2}\.\d{1,2}\.\d{4}\b)")  # 10:00:01, 3/1/2026, 1.3.2026
_DATE = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d(\.\d{1,9})?)?Z?")

if TYPE_CHECKING:
    from _csv import Reader as Rows

T = TypeVar("T")
_FAULTS = (OSError, csv.Error, UnicodeDecodeError)
_REMEDY = "save it as UTF-8 text with separated cells"


def recognises(path: Path) -> bool:
    """A file of one of the suffixes."""
    return path.is_file() and path.suffix.lower() in SUFFIXES


def open_recording(path: Path, time: str | None, time_scale: float | None) -> Table:
    """The table, by its header; lines before it that begin with # are skipped."""
    with border(path, _FAULTS, _REMEDY), path.open(encoding="utf-8-sig", newline="") as file:
        skipped, line = _header(file)
    separator = max(",;\t", key=line.count)
    with border(path, _FAULTS, _REMEDY):
        names = [name.strip() for name in next(csv.reader([line], delimiter=separator), [])]
    while names and not names[-1]:
        names.pop()
    if not names:
        raise InputError(f"{path}: is empty; its first line must name the columns")
    if all(_is_number(name) for name in names):
        raise InputError(f"{path}: begins with numbers; its first line must name the columns")
    if twice := [name for name in dict.fromkeys(names) if names.count(name) > 1]:
        raise InputError(f"{path}: column {shown(twice[0])} is there twice; rename one")

    def chunks(wanted: Sequence[str], progress: Progress) -> Iterator[Chunk]:
        return _chunks(path, skipped, separator, names, wanted, progress)

    return Table(path, [Channel(name, "column") for name in names], chunks, time, time_scale)


def _header(file: TextIO) -> tuple[int, str]:
    """How many lines stand before the header, and the header."""
    skipped = 0
    for line in iter(lambda: file.readline(LONGEST), ""):
        if line.strip() and not line.startswith("#"):
            return skipped, line
        skipped += 1
    return skipped, ""


def _chunks(
    path: Path, skipped: int, separator: str, names: list[str], wanted: Sequence[str], progress: Progress
) -> Iterator[Chunk]:
    """Lines of nothing but numbers by NumPy's parser; from the first other line on cell by cell."""
    places = [names.index(name) for name in wanted]
    with path.open(encoding="utf-8-sig", newline="") as file:
        lines = iter(lambda: file.readline(LONGEST), "")
        deque(islice(lines, skipped + 1), maxlen=0)
        done = skipped + 1
        while block := _next(lines, path):
            if (cells := _plain(block, separator, len(names), places)) is None:
                break
            yield dict(zip(wanted, cells.T, strict=True))
            done += len(block)
            progress(done, 0)
        rows = csv.reader(chain(block, lines), delimiter=separator, strict=True)
        yield from _by_cell(path, done, separator, names, wanted, rows, progress)


def _next(items: Iterator[T], path: Path) -> list[T]:
    """The items of the next chunk."""
    with border(path, _FAULTS, _REMEDY):
        return list(islice(items, ROWS))


def _plain(lines: list[str], separator: str, cells: int, places: list[int]) -> np.ndarray | None:
    """The wanted cells (lines, places), or None where a line needs a closer look."""
    if any(line.count(separator) != cells - 1 or '"' in line for line in lines):
        return None
    if separator != ",":
        lines = [line.replace(",", ".") for line in lines]
    try:
        return np.loadtxt(lines, delimiter=separator, usecols=places, comments=None, ndmin=2)
    except ValueError:
        return None


def _by_cell(
    path: Path,
    before: int,
    separator: str,
    names: list[str],
    wanted: Sequence[str],
    rows: "Rows",
    progress: Progress,
) -> Iterator[Chunk]:
    """Chunks of `rows`, before which `before` lines stand; blank rows and cells are allowed."""
    places = [names.index(name) for name in wanted]
    numbered = ((before + rows.line_num, row) for row in rows)
    while chunk := _next(numbered, path):
        faults: list[str] = []
        cells, numbers = [], []
        for number, row in chunk:
            if not any(row):
                continue
            if len(row) < len(names) or any(cell.strip() for cell in row[len(names) :]):
                what = f"has {len(row)} cells, not {len(names)}; correct the row, the file may be cut off"
                faults.append(f"{path} row {number}: {what}")
                row += [""] * len(names)
            cells.append([row[place] for place in places])
            numbers.append(number)
        yield _columns(path, wanted, separator, numbers, cells, faults)
        progress(chunk[-1][0], 0)


def _columns(
    path: Path,
    wanted: Sequence[str],
    separator: str,
    numbers: Sequence[int],
    cells: Sequence[Sequence[str]],
    faults: list[str],
) -> Chunk:
    """Columns of numbers, NaN for blank cells; `InputError` with `faults` and the first cells that are neither."""
    result: dict[str, NDArray[np.generic]] = {}
    wrong: dict[int, list[str]] = {}
    for name, column in zip(wanted, zip(*cells, strict=True) if cells else [()] * len(wanted), strict=True):
        if separator != ",":
            column = tuple(cell.replace(",", ".") for cell in column)
        try:
            result[name] = _values(column)
        except ValueError:
            if _ANY_DATE.match(column[0]):
                remedy = "give all of them in UTC as 2026-03-01T10:00:00.000, or as seconds"
                faults.append(
                    f"{path} row {numbers[0]}: {name} is {shown(column[0])}, and not all dates are understood; {remedy}"
                )
                continue
            for i, cell in enumerate(column):
                if cell.strip() and not _is_number(cell):
                    wrong.setdefault(i, []).append(f"{name} is {shown(cell)}")
    for i, found in sorted(wrong.items())[:SHOWN]:
        remedy = "remove the row if it names units" if len(found) == len(wanted) > 1 else "correct the cell"
        faults.append(f"{path} row {numbers[i]}: {', '.join(found)}, not a number; {remedy}")
    if faults:
        raise InputError(faults[:SHOWN])
    return result


def _values(cells: Sequence[str]) -> NDArray[np.generic]:
    """Numbers, or dates (ISO 8601, UTC) where the first cell is one; `ValueError` where a cell is neither."""
    if cells and _DAY.match(cells[0]):
        if not all(_DATE.fullmatch(cell.strip()) for cell in cells if cell.strip()):
            raise ValueError("no date in UTC")
        return np.array([cell.strip().removesuffix("Z") or "NaT" for cell in cells], "datetime64[ns]")
    return np.array([float(cell.strip() or "nan") for cell in cells])


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True

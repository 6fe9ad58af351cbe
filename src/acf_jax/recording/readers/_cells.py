"""Cells of text to numbers: lines of nothing but numbers in blocks, all others cell by cell."""

import csv
from collections.abc import Iterator, Sequence
from operator import methodcaller
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from acf_jax.errors import InputError, shown
from acf_jax.recording.readers._layout import Layout
from acf_jax.recording.readers._table import Chunk
from acf_jax.recording.readers._text import Text
from acf_jax.recording.readers._values import STAMP_REMEDY, is_error, is_missing, is_stamp, stamps
from acf_jax.recording.series import Progress

SHOWN = 8  # faults shown
_HELD = 4  # blocks in which a quotation mark may stay open
_EXACT = 2.0**53  # whole numbers beyond are not exact as floats


def chunks(
    text: Text, layout: Layout, names: Sequence[str], wanted: Sequence[str], progress: Progress
) -> Iterator[Chunk]:
    """The wanted columns of a text, whose columns are `names`, in order."""
    places = [names.index(name) for name in wanted]
    done = layout.skip
    for block in _whole_rows(_after(text.blocks(), layout.skip)):
        lines = block.split("\n")
        cells = _plain(block, lines, layout.separator, layout.cells, places)
        if cells is not None:
            yield dict(zip(wanted, cells, strict=True))
        else:
            yield _by_cell(text.path, done, layout, len(names), wanted, places, lines)
        done += len(lines)
        progress(done, 0)


def _after(blocks: Iterator[str], skip: int) -> Iterator[str]:
    """The text after the first `skip` lines."""
    for block in blocks:
        parts = block.split("\n", skip)
        if len(parts) > skip:
            yield parts[skip]
        skip = max(skip - len(parts), 0)


def _whole_rows(blocks: Iterator[str]) -> Iterator[str]:
    """Blocks that end outside of quotes, within which a cell may have several lines."""
    held: list[str] = []
    for block in blocks:
        held.append(block)
        text = block if len(held) == 1 else "\n".join(held)
        if '"' not in text or text.count('"') % 2 == 0 or len(held) == _HELD:
            yield text
            held = []
    if held:
        yield "\n".join(held)


def _plain(
    text: str, lines: list[str], separator: str, cells: int, places: Sequence[int]
) -> list[NDArray[np.generic]] | None:
    """The wanted columns, or None where a line needs a closer look."""
    if '"' in text or "#" in text or not text.strip():
        return None
    if separator != "," and "," in text:
        lines = text.replace(",", ".").split("\n")
    blank = separator == " "
    if not blank and set(map(methodcaller("count", separator), lines)) != {cells - 1}:
        return None
    try:  # of cells between blanks NumPy tells a wrong number only where it reads all of them
        table = np.loadtxt(
            lines,
            delimiter=None if blank else separator,
            usecols=None if blank else places,
            comments=None,
            ndmin=2,
        )
    except ValueError:
        return None
    if blank and table.shape[1] != cells:
        return None
    columns = table.T[list(places)] if blank else table.T
    return [_exact(column, lines, separator, place) for column, place in zip(columns, places, strict=True)]


def _exact(
    column: NDArray[np.float64], lines: Sequence[str], separator: str, place: int
) -> NDArray[np.generic]:
    """A column of `lines`, its whole numbers exact where floats are not."""
    if not (np.abs(column) >= _EXACT).any():
        return column
    blank = None if separator == " " else separator
    return _whole([line.split(blank, place + 1)[place] for line in lines if line.strip()], column)


def _whole(cells: Sequence[str], otherwise: NDArray[np.float64]) -> NDArray[np.generic]:
    try:
        return np.array([int(cell) for cell in cells], np.int64)
    except (ValueError, OverflowError):
        return otherwise


def _by_cell(
    path: Path,
    before: int,
    layout: Layout,
    count: int,
    wanted: Sequence[str],
    places: Sequence[int],
    lines: Sequence[str],
) -> Chunk:
    """The wanted columns of lines, before which `before` lines stand; blank rows and cells and comments are allowed."""
    odd: dict[str, list[int]] = {}
    cells, numbers = [], []
    is_blank = layout.separator == " "
    whole = (
        (line.replace("\t", " ") + "\n" for line in lines) if is_blank else (line + "\n" for line in lines)
    )
    rows = csv.reader(whole, delimiter=layout.separator, skipinitialspace=is_blank, strict=True)
    try:
        for row in rows:
            if not "".join(row).strip() or _is_comment(row[0]):
                continue
            if len(row) < count or (not layout.remarks and any(cell.strip() for cell in row[count:])):
                what = f"has {len(row)} cells, not {count} as the header"
                odd.setdefault(what, []).append(before + rows.line_num)
                continue
            cells.append([row[place] for place in places])
            numbers.append(before + rows.line_num)
    except csv.Error:
        first = (numbers[-1] if numbers else before) + 1
        what = "its quotation marks do not go in pairs around cells"
        raise InputError(f"{path} row {first}: {what}; add or remove one there or below") from None
    remedy = "quote what holds a separator, or correct the row: the file may be cut off"
    faults = [
        f"{path} row {place[0]}{' and others' if len(place) > 1 else ''}: {what}; {remedy}"
        for what, place in odd.items()
    ]
    columns = zip(*cells, strict=True) if cells else [()] * len(wanted)
    return _columns(path, wanted, numbers, list(columns), faults)


def _columns(
    path: Path,
    wanted: Sequence[str],
    numbers: Sequence[int],
    columns: Sequence[Sequence[str]],
    faults: list[str],
) -> Chunk:
    """Columns of numbers, NaN for blank cells; `InputError` with `faults` and the first cells that are neither."""
    result: dict[str, NDArray[np.generic]] = {}
    wrong: dict[int, list[str]] = {}
    for name, column in zip(wanted, columns, strict=True):
        try:
            result[name] = _values(column)
        except ValueError:
            if is_stamp(_first(column)):
                i = next(i for i, cell in enumerate(column) if not _is_stamp_of_one_meaning(cell))
                what = f"{name} is {shown(column[i])}, no date or time of day that means one thing only"
                faults.append(f"{path} row {numbers[i]}: {what}; {STAMP_REMEDY}")
                continue
            for i, cell in enumerate(column):
                if not is_missing(cell) and not _is_float(cell):
                    wrong.setdefault(i, []).append(f"{name} is {shown(cell)}")
    for i, found in sorted(wrong.items())[:SHOWN]:
        remedy = "remove the row if it names units" if len(found) == len(wanted) > 1 else "correct the cell"
        faults.append(f"{path} row {numbers[i]}: {', '.join(found)}, not a number; {remedy}")
    if faults:
        raise InputError(faults[:SHOWN])
    return result


def _values(cells: Sequence[str]) -> NDArray[np.generic]:
    """Numbers, or dates where the first cell is one; `ValueError` where a cell is neither."""
    if is_stamp(_first(cells)):
        return stamps(cells)
    values = np.array([float("nan" if is_missing(cell) else cell.replace(",", ".")) for cell in cells])
    return _whole(cells, values) if (np.abs(values) >= _EXACT).any() else values


def _first(cells: Sequence[str]) -> str:
    """The first cell that is filled."""
    return next((cell for cell in cells if not is_missing(cell)), "")


def _is_comment(cell: str) -> bool:
    return cell.lstrip().startswith("#") and not is_error(cell)


def _is_stamp_of_one_meaning(cell: str) -> bool:
    try:
        stamps([cell])
    except ValueError:
        return False
    return True


def _is_float(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True

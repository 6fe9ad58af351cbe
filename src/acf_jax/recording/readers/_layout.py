"""Where a table begins within lines of text or rows of a sheet, its separator and the names of its columns."""

import csv
import re
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NamedTuple

from acf_jax.errors import InputError, shown
from acf_jax.recording.readers._values import is_missing, is_number
from acf_jax.recording.readers._words import is_signal, is_time, is_unit

SEPARATORS = ("\t", ";", ",", "|", " ")  # a blank stands for any white space
LOOKED_AT = 500  # lines or rows, of which those before the header are a part
_ENOUGH = 10  # rows of numbers after which a line is the header, whatever follows
_MARK = re.compile(r"\s*(#+|%+|//+|!+|\*+)\s*")  # of comments, also before a header
# Cells with blanks in them: two or more blanks apart, or a name and its unit.
_WIDE = re.compile(r"\t+| {2,}")
_NAME_AND_UNIT = re.compile(r"\S+(?:\s+[\[(][^\])]*[\])])?")


class Header(NamedTuple):
    """The header of rows of cells."""

    names: list[str]  # none where no row names the columns
    row: int  # of the names
    units: int | None  # the row of units, or another below the names
    first: int  # row after the header
    cells: int  # of a row of numbers
    score: int  # cells that are numbers, less those that are not, in rows of numbers


@dataclass(frozen=True)
class Layout:
    """How a text holds a table."""

    separator: str
    names: list[str]
    skip: int  # lines before the first row of numbers
    cells: int  # of such a row
    units: Sequence[str] = ()  # of a row between them
    units_line: int = 0  # from 1
    remarks: bool = False  # whether words may stand behind the last cell of a row

    def notes(self, path: Path) -> list[str]:
        """What a user should know of how the table was found."""
        if not self.units:
            return []
        cells = ", ".join(shown(cell) for cell in self.units[:8])
        return [f"{path} line {self.units_line}: is taken for a row of units: {cells}"]

    def fault(self, path: Path) -> str | None:
        """What has to be known where a column is not found: none has a name."""
        if any(self.names):
            return None
        called = f"'column 1' to 'column {self.cells}'"
        return f"{path}: begins with numbers; its first line must name the columns, which are {called} now"


def split(line: str, separator: str) -> list[str]:
    """The cells of a line."""
    if '"' in line:
        blank = separator == " "
        text = line.replace("\t", " ") if blank else line
        with suppress(csv.Error):  # a cell is too long: it is no row of a table
            return [c.strip() for c in next(csv.reader([text], delimiter=separator, skipinitialspace=blank))]
    return line.split() if separator == " " else [cell.strip() for cell in line.split(separator)]


def find_layout(path: Path, lines: Sequence[str]) -> Layout:
    """The separator by which header and rows of numbers agree, and by which most cells are numbers.

    **Raises:** `InputError` when there are no lines.
    """
    lines = lines[:LOOKED_AT]
    if not any(line.strip() for line in lines):
        raise InputError(f"{path}: is empty; its first line must name the columns")
    marked = frozenset(i for i, line in enumerate(lines) if line.lstrip().startswith("#"))
    found: list[tuple[tuple[bool, int], str, Header]] = []
    for separator in SEPARATORS:
        rows = [split(line, separator) for line in lines]
        if header := find_header(rows, partial(_named, lines, separator), marked):
            found.append(((bool(header.names), header.score), separator, header))
    if not found:
        return _without_numbers(lines, marked)
    _, separator, header = max(found, key=lambda one: one[0])
    if not header.names and (place := _mismatched(lines, separator, header.first, marked)) is not None:
        names = trimmed(split(lines[place], separator))
        return Layout(separator, names, place + 1, len(names))
    names = header.names or [""] * header.cells
    if header.units is None:
        return Layout(separator, names, header.first, header.cells)
    units = _named(lines, separator, header.units, 1, header.cells) or []
    return Layout(separator, names, header.first, header.cells, units, header.units + 1)


def find_header(
    rows: Sequence[Sequence[str]],
    named: Callable[[int, int, int], list[str] | None],
    marked: frozenset[int] = frozenset(),
) -> Header | None:
    """The first row that has as many cells as the rows of numbers below it; None where no row holds numbers.

    **Arguments:** rows of cells; `named(i, low, high)`, the cells of row i as names, if they are low to high in
    number; rows behind the mark of a comment.
    """
    plain = {i: sum(map(is_number, row)) for i, row in enumerate(rows) if i not in marked}
    weights: Counter[int] = Counter()
    for i, count in plain.items():
        weights[len(rows[i])] += count
    cells = max(weights, key=lambda n: (weights[n], n), default=0)
    if not weights[cells]:
        return None
    alike = [i for i, count in plain.items() if count and len(rows[i]) == cells]
    filled = [[rows[i][j] for i in alike if not is_missing(rows[i][j])] for j in range(cells)]
    if not any(filled):
        return None
    numeric = [j for j in range(cells) if 2 * sum(map(is_number, filled[j])) > len(filled[j])]
    low = max(j + 1 for j in range(cells) if filled[j])  # a separator may end each row

    def is_words(row: Sequence[str]) -> bool:
        there = [row[j] for j in numeric if j < len(row) and not is_missing(row[j])]
        return 2 * sum(map(is_number, there)) < len(there)

    numbers = [i for i in alike if not is_words(rows[i])]
    score = sum(1 if is_number(cell) else -1 for i in numbers for cell in rows[i] if not is_missing(cell))
    begin = numbers[0] if numbers else len(rows)
    # a comment below the first numbers is no header
    places = [i for i in range(len(rows)) if i < begin or i not in marked]
    heads = {i: row for i in places if (row := named(i, low, cells)) and is_words(row)}
    first = named(begin, low, cells) if not heads and len(numbers) > 1 else None
    if first and not all(is_number(first[j]) for j in numeric if j < len(first) and first[j]):
        heads = {numbers.pop(0): first}  # time,1,2,3
    if not heads:
        return Header([], 0, None, begin, cells, score) if numbers else None
    group = _followed(_groups(heads, rows, marked), numbers)
    group = [i for i in group if i not in marked] or group

    def telling(i: int) -> tuple[bool, bool, bool, int]:
        """How much row i tells of the columns: least is a row of units, then one that is separated otherwise."""
        known = sum(is_time(cell) or is_signal(cell) for cell in heads[i])
        is_of_units = not known and any(is_unit(cell) for cell in heads[i])
        return known > 0, not is_of_units, heads[i][-1:] == trimmed(rows[i])[-1:], known

    top = max(group, key=telling)  # the first of them
    below = [i for i in group if i > top]
    of_units = (i for i in group if i != top and any(is_unit(cell) for cell in heads[i]))
    units = next(of_units, below[0] if below else None)
    return Header(heads[top], top, units, group[-1] + 1, cells, score)


def _groups(
    heads: dict[int, list[str]], rows: Sequence[Sequence[str]], marked: frozenset[int]
) -> list[list[int]]:
    """Rows of names that follow each other, but for blank ones and comments."""
    groups: list[list[int]] = []
    adjoins = False
    for i, row in enumerate(rows):
        if i in heads:
            groups = [*groups[:-1], [*groups[-1], i]] if adjoins else [*groups, [i]]
            adjoins = True
        elif any(row) and i not in marked:
            adjoins = False
    return groups


def _followed(groups: list[list[int]], numbers: Sequence[int]) -> list[int]:
    """The first group after which rows of numbers follow."""
    ends = [*(group[0] for group in groups[1:]), float("inf")]
    counts = [sum(group[-1] < i < end for i in numbers) for group, end in zip(groups, ends, strict=True)]
    enough = next((i for i, count in enumerate(counts) if count >= _ENOUGH), None)
    return groups[counts.index(max(counts)) if enough is None else enough]


def _named(lines: Sequence[str], separator: str, i: int, low: int, high: int) -> list[str] | None:
    """The names in a line, low to high in number: separated as the rows are, or otherwise where they tell signals."""
    line = lines[i]
    mark = _MARK.match(line)
    bare = line[mark.end() :] if mark else line
    for text in (bare,) if line.lstrip().startswith("#") else (line, bare):
        if low <= len(cells := trimmed(split(text, separator))) <= high:
            return cells
        others = [trimmed(split(text, other)) for other in SEPARATORS if other != separator]
        others += [_WIDE.split(text.strip()), _NAME_AND_UNIT.findall(text)]
        for cells in others:
            if low <= len(cells) <= high and len(cells) > 1 and _tells(cells):
                return cells
    return None


def _tells(cells: Sequence[str]) -> bool:
    """Whether one of the cells is called a time, or two a signal."""
    return any(map(is_time, cells)) or sum(map(is_signal, cells)) > 1


def trimmed(cells: Sequence[str]) -> list[str]:
    """The cells without blank ones at the end."""
    last = max((i for i, cell in enumerate(cells, 1) if cell), default=0)
    return list(cells[:last])


def _mismatched(lines: Sequence[str], separator: str, first: int, marked: frozenset[int]) -> int | None:
    """The line that names a time, or else the words right before the numbers, though they are not as many."""
    before = [i for i in range(first) if lines[i].strip() and i not in marked]
    cells = {i: trimmed(split(lines[i], separator)) for i in before}
    words = [i for i in before if len(cells[i]) > 1 and 2 * sum(map(is_number, cells[i])) < len(cells[i])]
    of_time = [i for i in words if any(map(is_time, cells[i]))]
    return next(iter(of_time or [i for i in words if i == before[-1]]), None)


def _without_numbers(lines: Sequence[str], marked: frozenset[int]) -> Layout:
    """The first line that is no comment names the columns."""
    i = next((i for i, line in enumerate(lines) if line.strip() and i not in marked), 0)
    separator = max(SEPARATORS, key=lambda one: len(split(lines[i], one)))
    names = trimmed(split(lines[i], separator))
    return Layout(separator, names or [""], i + 1, len(names))

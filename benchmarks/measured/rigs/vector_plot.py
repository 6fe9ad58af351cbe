"""Numbers out of a published vector plot: a PDF page by LaTeX whose curves have one vertex a sample."""

import re
import zlib
from pathlib import Path

import numpy as np

from acf_jax.errors import InputError
from benchmarks.measured.recorded import Array

_POINT = re.compile(r"(-?[\d.]+) (-?[\d.]+) ([ml])$")
_TEXT = re.compile(r"\((.*?)\)")


def read_curves(path: Path) -> list[tuple[Array, Array]]:
    """The curves of a plot in the units of its axes, in the order in which they were drawn."""
    page = _page(path)
    paths, labels = _paths_and_labels(page)
    grid = [p for p in paths if len(p) > 1 and len({move for *_, move in p}) == 2][:2]
    if len(grid) < 2:
        raise InputError([f"{path}: it has no axes; copy the repository again"])
    ticks = [
        sorted({x for x, _, move in grid[0] if move == "m"}),
        sorted({y for _, y, move in grid[1] if move == "m"}),
    ]
    numbers = [n for text in labels if (n := _number(text)) is not None]
    count = len(ticks[0])
    if len(numbers) != count + len(ticks[1]):
        raise InputError([f"{path}: its axes are not those of a plot by LaTeX; copy the repository again"])
    scales = [
        np.polyfit(at, says, 1)  # a straight line through all ticks
        for at, says in zip(ticks, (numbers[:count], numbers[count:]), strict=True)
    ]
    curves = [np.array([(x, y) for x, y, _ in p]) for p in paths if len(p) > 100]
    return [(np.polyval(scales[0], c[:, 0]), np.polyval(scales[1], c[:, 1])) for c in curves]


def _page(path: Path) -> str:
    """The longest stream of drawing commands."""
    raw, pages = path.read_bytes(), []
    for found in re.finditer(rb"stream\r?\n", raw):
        try:
            pages.append(zlib.decompressobj().decompress(raw[found.end() :]))
        except zlib.error:
            continue  # a font, or the word in other text
    if not pages:
        raise InputError([f"{path} is not a PDF with compressed pages; copy the repository again"])
    return max(pages, key=len).decode("latin1")


def _paths_and_labels(page: str) -> tuple[list[list[tuple[float, float, str]]], list[str]]:
    """The strokes of a page, and its texts line by line (a label ends where its text block does)."""
    paths: list[list[tuple[float, float, str]]] = []
    labels: list[str] = []
    path: list[tuple[float, float, str]] = []
    text = ""
    for line in map(str.strip, page.split("\n")):
        if point := _POINT.match(line):
            path.append((float(point[1]), float(point[2]), point[3]))
        elif line in ("S", "n"):  # stroked, or only a clip
            if line == "S":
                paths.append(path)
            path = []
        elif "TJ" in line:
            text += "".join(_TEXT.findall(line))
        if line.endswith("ET"):
            labels.append(text)
            text = ""
    return paths, labels


def _number(text: str) -> float | None:
    """A label as a number: in LaTeX's fonts 0 is a minus, 1 the dot of a product, and a colon the decimal point."""
    factor, _, exponent = text.replace("\\000", "-").replace(":", ".").partition("\\00110")
    try:
        return float(factor) * 10.0 ** float(exponent or 0)
    except ValueError:
        return None

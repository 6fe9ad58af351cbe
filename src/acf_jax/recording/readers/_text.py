"""Text files in bounded blocks of lines: whatever their encoding, packed by gzip or not."""

import codecs
import gzip
import io
import re
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, cast

from acf_jax.errors import InputError, shown
from acf_jax.recording.readers._bounds import check_rows, check_unpacked
from acf_jax.recording.readers._guard import border

BLOCK = 1 << 19  # characters read at once
LONGEST = 1_000_000  # characters of a line
SUFFIXES = (".csv", ".tsv", ".txt", ".dat", ".asc", ".prn", ".log", ".lvm")
FAULTS = (OSError, EOFError, zlib.error)
REMEDY = "save it as text with separated cells"
_HEAD = 1 << 18  # bytes by which the encoding is known
_PADDING = 1 << 16  # zeros that may follow a packed file, as from a tape or a flash disk
_MARKS = {  # that of UTF-32 begins as that of UTF-16
    codecs.BOM_UTF32_LE: "utf-32", codecs.BOM_UTF32_BE: "utf-32",
    codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16", codecs.BOM_UTF8: "utf-8-sig",
}  # fmt: skip
_CONTROL = re.compile(r"[\0-\x08\x0e-\x1f]")
_BINARY = 0.01  # share of control characters that no text has, though damage may bring a few


def is_called_text(path: Path) -> bool:
    """Whether the name of a file is that of a text, packed or not."""
    return path.name.lower().removesuffix(".gz").endswith(SUFFIXES)


class Text:
    """The lines of a text file; `InputError` where it holds something else."""

    def __init__(self, path: Path):
        self.path = path
        with border(path, FAULTS, REMEDY), self._bytes() as file:
            head = file.read(_HEAD)
        self.encoding = _encoding(head)
        _check_text(path, head.decode(self.encoding, "replace"))

    @property
    def notes(self) -> list[str]:
        """What a user should know of the encoding."""
        return [f"{self.path}: is not UTF-8; read as Windows-1252"] if self.encoding == "cp1252" else []

    @property
    def fault(self) -> str | None:
        """What has to be known where a column is not found: its name may be spelt otherwise."""
        return (
            f"{self.path}: is not UTF-8, and names may be misread; save it as UTF-8" if self.notes else None
        )

    def blocks(self) -> Iterator[str]:
        """The text in blocks of whole lines, ends of lines as \\n and none at the end.

        **Raises:** `InputError` for a line, or a content of a packed file, that is longer than any table's.
        """
        done = 0
        with border(self.path, FAULTS, REMEDY):
            raw = self._bytes()
        # a byte that does not belong can only stand in words: numbers are ASCII
        with io.TextIOWrapper(raw, self.encoding, "replace") as file:
            while True:
                with border(self.path, FAULTS, REMEDY):
                    text = file.read(BLOCK)
                    if text and not text.endswith("\n"):
                        text += file.readline(LONGEST + 1)
                if not text:
                    return
                if len(text) > LONGEST:  # blocks are shorter, but for a last line that is long
                    _check_lines(self.path, text.split("\n"))
                if isinstance(raw, gzip.GzipFile):
                    done += text.count("\n")
                    check_rows(self.path, done)
                    check_unpacked(self.path, raw.tell())
                yield text.removesuffix("\n")

    def head(self) -> list[str]:
        """The lines of the first block."""
        return next(self.blocks(), "").split("\n")

    def _bytes(self) -> BinaryIO:
        if self.path.suffix.lower() != ".gz":
            return self.path.open("rb")
        with self.path.open("rb") as file:
            file.seek(max(0, self.path.stat().st_size - _PADDING))
            if not any(end := file.read(_PADDING)) and len(end) == _PADDING:  # gzip skips zeros one by one
                raise InputError(f"{self.path}: ends in zeros; save it again")
        return cast(BinaryIO, gzip.open(self.path))


def _check_text(path: Path, start: str) -> None:
    controls = [found.start() for found in _CONTROL.finditer(start)]
    if len(controls) <= _BINARY * len(start):
        return
    if line := start.count("\n", 0, controls[0]):
        raise InputError(
            f"{path} row {line + 1}: holds no text, as after a loss of power; cut the file off there"
        )
    raise InputError(f"{path}: holds no text; name it by its kind, such as .mat or .npz, or {REMEDY}")


def _check_lines(path: Path, lines: list[str]) -> None:
    if long := next((line for line in lines if len(line) > LONGEST), None):
        raise InputError(
            f"{path}: the line that begins with {shown(long)} is longer than {LONGEST:,} characters; {REMEDY}"
        )


def _encoding(head: bytes) -> str:
    """By the mark at the start or, of ASCII in UTF-16, by its zeros; what is not UTF-8 is what Windows writes."""
    for mark, encoding in _MARKS.items():
        if head.startswith(mark):
            return encoding
    first = head[:64]
    if len(first) > 3 and b"\0" in first:
        for start, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
            if not any(first[start::2]) and all(first[1 - start :: 2]):
                return encoding
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8"

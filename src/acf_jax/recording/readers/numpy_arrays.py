"""NumPy files: named arrays (.npz), or one array of named fields (.npy). Nothing is unpickled."""

import struct
import tokenize
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from acf_jax.errors import InputError, shown
from acf_jax.recording.readers._guard import border
from acf_jax.recording.readers._table import Chunk, Table
from acf_jax.recording.series import Channel, Progress

KIND = "NumPy arrays with names (.npz, .npy)"
SUFFIXES = (".npz", ".npy")
ROWS = 1_000_000  # of a chunk

# zipfile and NumPy use sizes and names in a damaged file before they check them.
_UNCHECKED = (LookupError, ArithmeticError, TypeError, AttributeError, RuntimeError, MemoryError, SyntaxError)
_BROKEN = (zipfile.BadZipFile, zlib.error, struct.error, tokenize.TokenError)
_FAULTS = (OSError, EOFError, ValueError, *_BROKEN, *_UNCHECKED)
_REMEDY = "save it again by numpy.savez, arrays of numbers only"


def recognises(path: Path) -> bool:
    """A file of one of the suffixes."""
    return path.is_file() and path.suffix.lower() in SUFFIXES


def open_recording(path: Path, time: str | None, time_scale: float | None) -> Table:
    """The arrays by name; those of one length are the rows of a table."""
    if path.suffix.lower() == ".npz":
        with (
            border(path, _FAULTS, _REMEDY),
            path.open("rb") as opened,
            np.load(opened, allow_pickle=False) as file,
        ):
            columns = [Channel(name, "array") for name in file.files]
        loader = _load_npz
    else:
        with border(path, _FAULTS, _REMEDY):
            array = np.load(path, mmap_mode="r", allow_pickle=False)
        if array.dtype.names is None:
            remedy = "save named arrays by numpy.savez(FILE, time_s=..., force_n=...)"
            raise InputError(f"{path}: is an array without names; {remedy}")
        columns = [Channel(name, str(array.dtype[name]), array.size) for name in array.dtype.names]
        loader = _load_npy
    if not columns:
        raise InputError(f"{path}: holds no arrays; {_REMEDY}")

    def chunks(wanted: Sequence[str], progress: Progress) -> Iterator[Chunk]:
        with border(path, _FAULTS, _REMEDY):
            arrays = loader(path, wanted)
        lengths = {name: array.shape for name, array in arrays.items()}
        if len(set(lengths.values())) > 1 or any(len(shape) != 1 for shape in lengths.values()):
            listed = ", ".join(f"{shown(name)} {shape}" for name, shape in lengths.items())
            raise InputError(
                f"{path}: the arrays {listed} must be of one dimension and length; cut them to it"
            )
        size = next(iter(lengths.values()))[0]
        for first in range(0, max(size, 1), ROWS):
            yield {name: array[first : first + ROWS] for name, array in arrays.items()}
            progress(min(first + ROWS, size), size)

    return Table(path, columns, chunks, time, time_scale)


def _load_npz(path: Path, wanted: Sequence[str]) -> dict[str, np.ndarray]:
    # NumPy leaves a damaged file open that it has opened itself
    with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
        return {name: file[name] for name in wanted}


def _load_npy(path: Path, wanted: Sequence[str]) -> dict[str, np.ndarray]:
    array = np.load(path, mmap_mode="r", allow_pickle=False)
    return {name: array[name] for name in wanted}

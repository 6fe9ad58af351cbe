"""NumPy files: named arrays (.npz), or one array of named fields (.npy). Nothing is unpickled."""

import struct
import tokenize
import zipfile
import zlib
from functools import lru_cache, partial
from pathlib import Path

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from acf_jax.errors import InputError
from acf_jax.recording.mapping import Mapping
from acf_jax.recording.readers._arrays import Index, Stored, array_table, part_of
from acf_jax.recording.readers._bounds import check_unpacked
from acf_jax.recording.readers._guard import border
from acf_jax.recording.readers._table import Table

KIND = "NumPy arrays with names (.npz, .npy)"
SUFFIXES = (".npz", ".npy")

# zipfile and NumPy use sizes and names in a damaged file before they check them.
_UNCHECKED = (LookupError, ArithmeticError, TypeError, AttributeError, RuntimeError, MemoryError, SyntaxError)
_BROKEN = (zipfile.BadZipFile, zlib.error, struct.error, tokenize.TokenError)
_FAULTS = (OSError, EOFError, ValueError, *_BROKEN, *_UNCHECKED)
_MOST = 1000  # arrays: their list is read again for each that is looked at
_REMEDY = "save it again by numpy.savez, arrays of numbers only"


def recognises(path: Path) -> bool:
    """A file of one of the suffixes."""
    return path.is_file() and path.suffix.lower() in SUFFIXES


def open_recording(path: Path, stated: Mapping) -> Table:
    """The arrays by name."""
    with border(path, _FAULTS, _REMEDY):
        arrays = _in_npz(path) if path.suffix.lower() == ".npz" else _in_npy(path)
    if not arrays:
        raise InputError(f"{path}: holds no arrays; {_REMEDY}")
    return array_table(path, arrays, stated, _FAULTS, _REMEDY)


def _in_npz(path: Path) -> list[Stored]:
    """The arrays of a zip file by their headers."""
    load = lru_cache(maxsize=1)(partial(_array, path))  # of a matrix one column after the other is asked for
    found = []
    with zipfile.ZipFile(path) as file:
        if len(file.infolist()) > _MOST:
            raise InputError(f"{path}: holds {len(file.infolist()):,} arrays; keep those that are needed")
        for member in file.infolist():
            name = member.filename.removesuffix(".npy")
            if name == member.filename:
                continue
            with file.open(member) as opened:
                version = npy.read_magic(opened)
                header = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
                shape, _, dtype = header(opened)
            found.append(Stored(name, shape, str(dtype), part_of(load, name)))
    return found


def _array(path: Path, name: str) -> NDArray[np.generic]:
    # NumPy leaves a damaged file open that it has opened itself
    with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
        check_unpacked(path, file.zip.getinfo(f"{name}.npy").file_size)
        return file[name]


def _in_npy(path: Path) -> list[Stored]:
    """The fields of one array."""
    array = np.load(path, mmap_mode="r", allow_pickle=False)
    if array.dtype.names is None:
        remedy = "save named arrays by numpy.savez(FILE, time_s=..., force_n=...)"
        raise InputError(f"{path}: is an array without names; {remedy}")

    def load(name: str, index: Index) -> NDArray[np.generic]:
        return np.load(path, mmap_mode="r", allow_pickle=False)[name][index]

    return [
        Stored(name, array[name].shape, str(array.dtype[name]), partial(load, name))
        for name in array.dtype.names
    ]

"""MATLAB files: version 5 through SciPy, 7.3, which is HDF5, through h5py; arrays, and the fields of structs."""

import struct
import zlib
from collections.abc import Iterator
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from acf_jax.errors import InputError
from acf_jax.recording.mapping import Mapping
from acf_jax.recording.readers import hdf5
from acf_jax.recording.readers._arrays import Stored, array_table, part_of
from acf_jax.recording.readers._bounds import check_unpacked
from acf_jax.recording.readers._guard import Faults, border, need
from acf_jax.recording.readers._table import Table

KIND = "a MATLAB file (.mat)"
# SciPy uses what a damaged file says before it checks it.
_UNCHECKED: Faults = (OSError, EOFError, ValueError, TypeError, LookupError, AttributeError, ArithmeticError,
                   NotImplementedError, RuntimeError, MemoryError, zlib.error, struct.error)  # fmt: skip
_REMEDY = "save vectors: save('FILE.mat', 'time', 'force', ...)"
_OPAQUE = (
    "holds a table, timetable or object, which only MATLAB reads; save its columns as vectors:"
    " time = seconds(T.Time); force = T.force; save('FILE.mat', 'time', 'force')"
)
_PACKED = 15  # type of an element that zlib has packed
_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def recognises(path: Path) -> bool:
    """A file of the suffix."""
    return path.is_file() and path.suffix.lower() == ".mat"


def open_recording(path: Path, stated: Mapping) -> Table:
    """The arrays of numbers, those in structs as STRUCT.FIELD."""
    with border(path, (OSError,), _REMEDY), path.open("rb") as file:
        head = file.read(520)
    if _SIGNATURE in (head[:8], head[512:]):
        h5py = need("h5py", "mat", f"{path}: reading a MATLAB file of version 7.3")
        return hdf5.datasets(h5py, path, stated, _REMEDY, _OPAQUE)
    from scipy.io.matlab import MatReadError

    faults = (*_UNCHECKED, MatReadError)
    with border(path, faults, _REMEDY):
        check_unpacked(path, _unpacked(path))
        arrays, opaque = _arrays(path)
    if not arrays:
        raise InputError(f"{path}: {_OPAQUE if opaque else f'holds no arrays of numbers; {_REMEDY}'}")
    fault = f"{path}: {_OPAQUE}" if opaque else None
    return array_table(path, arrays, stated, faults, _REMEDY, fault=fault)


def _unpacked(path: Path) -> int:
    """Bytes in the packed elements of a file of version 5; `InputError` once they are too many."""
    total = 0
    with path.open("rb") as file:
        order = {b"IM": "<II", b"MI": ">II"}.get(file.read(128)[126:])
        while order and len(tag := file.read(8)) == 8:
            kind, size = struct.unpack(order, tag)
            if not kind:  # no element has type 0: what follows is padding
                return total
            if kind != _PACKED:
                file.seek(size, 1)
                continue
            unpack = zlib.decompressobj()
            while size and (part := file.read(min(size, 1 << 16))):
                size -= len(part)
                total += len(unpack.decompress(part))
                check_unpacked(path, total)
    return total


def _arrays(path: Path) -> tuple[list[Stored], bool]:
    """The arrays of numbers by what the file says of them, and whether it holds what only MATLAB reads."""
    from scipy.io import loadmat, whosmat

    load = lru_cache(maxsize=1)(
        partial(_variable, path)
    )  # of a matrix one column after the other is asked for
    found: list[Stored] = []
    try:
        listed = whosmat(path, appendmat=False)
    except TypeError:  # of a table or an object SciPy knows no size
        for name, value in loadmat(path, appendmat=False).items():
            found += _fields(name, value)
        return found, True
    for name, shape, kind in listed:
        if kind in ("double", "single", "logical") or "int" in kind:
            found.append(Stored(name, shape, kind, part_of(load, name)))
        elif kind == "struct" and np.prod(shape) == 1:
            found += _fields(name, _variable(path, name))
    return found, any(kind in ("opaque", "object") for _, _, kind in listed)


def _variable(path: Path, name: str) -> Any:
    from scipy.io import loadmat

    return loadmat(path, variable_names=[name], appendmat=False)[name]


def _fields(name: str, value: Any) -> Iterator[Stored]:
    """The arrays of numbers in a struct."""
    if type(value) is not np.ndarray or name.startswith(
        "__"
    ):  # objects and functions are classes of their own
        return
    if value.dtype.names and value.size == 1:
        for field in value.dtype.names:
            yield from _fields(f"{name}.{field}", value.flat[0][field])
    elif value.dtype.kind in "fiub":
        yield Stored(name, value.shape, str(value.dtype), value.__getitem__)

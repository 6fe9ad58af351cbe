"""HDF5 files, through h5py: datasets by their paths, which links never lead out of the file."""

import zlib
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acf_jax.errors import InputError
from acf_jax.recording.mapping import Mapping
from acf_jax.recording.readers._arrays import Index, Stored, array_table
from acf_jax.recording.readers._bounds import check_unpacked
from acf_jax.recording.readers._guard import Faults, border, need
from acf_jax.recording.readers._table import Table

KIND = "HDF5 (.h5, .hdf5)"
SUFFIXES = (".h5", ".hdf5", ".he5", ".hdf")
FAULTS: Faults = (OSError, zlib.error, ValueError, LookupError, TypeError, AttributeError, RuntimeError,
                  ArithmeticError, NotImplementedError, MemoryError)  # fmt: skip
REMEDY = "the file is damaged, not closed or packed by a filter that is not installed; write it again"
_SMALL = 1 << 18  # bytes of a packed chunk, from which not even zeros make more than 256 MB


def recognises(path: Path) -> bool:
    """A file of one of the suffixes."""
    return path.is_file() and path.suffix.lower() in SUFFIXES


def open_recording(path: Path, stated: Mapping) -> Table:
    """The datasets of numbers, and the fields of those with named fields."""
    h5py: Any = need("h5py", "hdf5", f"{path}: reading HDF5")
    return datasets(h5py, path, stated, REMEDY)


def datasets(h5py: Any, path: Path, stated: Mapping, remedy: str, opaque: str = "") -> Table:
    """The table of an HDF5 file; `opaque` is said of what only MATLAB reads."""
    found: list[Stored] = []
    units: dict[str, str] = {}
    objects: list[str] = []

    def visit(name: str, node: Any) -> None:
        if not isinstance(node, h5py.Dataset):
            return
        if "MATLAB_object_decode" in node.attrs:
            objects.append(name)
        elif _holds_numbers(name, node):
            unit = node.attrs.get("units", node.attrs.get("unit"))
            if isinstance(unit, np.ndarray) and unit.size == 1:
                unit = unit.item()
            if isinstance(unit, str | bytes):
                units[name] = unit.decode(errors="replace") if isinstance(unit, bytes) else unit
            for field in node.dtype.names or (None,):
                whole = name if field is None else f"{name}/{field}"
                kind = node.dtype if field is None else node.dtype[field]
                found.append(Stored(whole, node.shape, str(kind), partial(_load, path, name, field)))

    with border(path, FAULTS, remedy), h5py.File(path, "r") as file:
        file.visititems(visit)
    fault = f"{path}: {opaque}" if objects and opaque else None
    if not found:
        raise InputError(fault or f"{path}: holds no datasets of numbers; write times and signals as vectors")
    return array_table(path, found, stated, FAULTS, remedy, units=units, fault=fault)


def _holds_numbers(name: str, node: Any) -> bool:
    """Whether a dataset is one of numbers or of named fields, and none that MATLAB keeps for itself."""
    hidden = name.startswith("#") or "MATLAB_empty" in node.attrs
    text = node.attrs.get("MATLAB_class", b"double") in (b"char", b"cell", b"function_handle")
    return not hidden and not text and node.shape is not None and node.dtype.kind in "fiubV"


def _load(path: Path, name: str, field: str | None, index: Index) -> NDArray[np.generic]:
    import h5py

    with h5py.File(path, "r") as file:
        data = file[name]
        if data.external or data.is_virtual:
            raise InputError(f"{path}: {name} is kept in another file; copy it into this one")
        if data.chunks:
            _check_chunks(path, data)
        return (data if field is None else data.fields(field))[index]


def _check_chunks(path: Path, data: Any) -> None:
    """`InputError` where a chunk of a dataset would unpack to more than chunks are said to hold."""
    size = data.dtype.itemsize * int(np.prod(data.chunks))
    check_unpacked(path, size)
    if data.compression != "gzip":
        return
    large: list[tuple[int, ...]] = []
    data.id.chunk_iter(lambda chunk: large.append(chunk.chunk_offset) if chunk.size > _SMALL else None)
    for offset in large:
        _, packed = data.id.read_direct_chunk(offset)
        if len(zlib.decompressobj().decompress(packed, size + _SMALL)) > size + _SMALL // 2:
            raise InputError(
                f"{path}: a chunk of {data.name} unpacks to more than it is said to hold; {REMEDY}"
            )

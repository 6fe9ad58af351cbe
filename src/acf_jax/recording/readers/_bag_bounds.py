"""Bounds on what a bag unfolds to: a few bytes in it can stand for more than any memory or disk holds."""

import bz2
import sqlite3
import sys
from collections.abc import Callable, Iterable
from contextlib import closing
from importlib import import_module
from itertools import accumulate
from pathlib import Path
from types import ModuleType
from typing import Any
from urllib.parse import quote

from acf_jax.files import MAX_BYTES, check_ordinary, read_yaml_mapping
from acf_jax.recording.readers._guard import Oversized

METADATA_BYTES = 2_000_000  # of a metadata.yaml; one of 10,000 parts is as large
AT_ONCE = 5 * MAX_BYTES  # of the chunks that lie over one time, which are merged
SWELL = (
    100  # times its packed size: times of messages are noise in their last digits, and do not pack further
)


def zstd() -> ModuleType:
    """The module that unpacks zstd: of Python from 3.14 on, else the one that rosbags brings."""
    return import_module("compression.zstd" if sys.version_info >= (3, 14) else "backports.zstd")


def check_folder(path: Path) -> None:
    """Refuse a folder of a bag with anything but ordinary files, or with metadata or packed files too large.

    **Raises:** `InputError`, `Oversized`.
    """
    for file in sorted(path.iterdir()):
        if file.name == "metadata.yaml" or not file.is_dir():
            check_ordinary(file, METADATA_BYTES if file.name == "metadata.yaml" else None)
    metadata = path / "metadata.yaml"
    # read here before rosbags reads it: aliases of aliases in it would stand for more than any memory holds
    found = read_yaml_mapping(metadata).get("rosbag2_bagfile_information") if metadata.exists() else {}
    if isinstance(found, dict) and str(found.get("compression_mode")).lower() == "file":
        for name in found.get("relative_file_paths", ()):
            _check_packed(path / Path(name).name)


def check_database(path: Path) -> None:
    """Refuse an sqlite3 file in which a table is computed, and may be without end; recorders only store.

    **Raises:** `Oversized`.
    """
    with closing(sqlite3.connect(f"file:{quote(str(path))}?immutable=1", uri=True)) as database:
        entries = database.execute("SELECT type, name, sql FROM sqlite_master").fetchall()
        tables = [str(name).replace('"', '""') for kind, name, _ in entries if kind == "table"]
        columns = [
            row for name in tables for row in database.execute(f'PRAGMA table_xinfo("{name}")').fetchall()
        ]
    computed = any(kind not in ("table", "index") for kind, *_ in entries)
    virtual = any(str(sql).upper().startswith("CREATE VIRTUAL") for *_, sql in entries)
    if computed or virtual or any(hidden for *_, hidden in columns):
        raise Oversized("computes its tables, which no recorder does; record it again")


def check_chunks(chunks: Iterable[Any]) -> None:
    """Refuse chunks of an MCAP index that lie over one time and are too much together; rosbags merges them.

    **Raises:** `Oversized`.
    """
    edges = [(c.message_start_time, c.uncompressed_size) for c in chunks]
    edges += [(c.message_end_time + 1, -c.uncompressed_size) for c in chunks]
    most = max(accumulate(size for _, size in sorted(edges)), default=0)
    if most > AT_ONCE:
        raise Oversized(
            f"has chunks of one time that unpack to {most / 1e6:.0f} MB together; convert it by `ros2 bag convert`"
        )


def bound_rosbags() -> None:
    """Make rosbags unpack chunks with a bound: by itself it unpacks them whole and then looks at the size."""
    from rosbags.rosbag1 import reader
    from rosbags.rosbag2 import storage_mcap

    lz4_frame, zstd_frame = import_module("lz4.frame").LZ4FrameDecompressor, zstd().ZstdDecompressor
    storage_mcap.DECOMPRESSORS.update(lz4=_of_size(lz4_frame), zstd=_of_size(zstd_frame))
    reader.decompressors.update(bz2=_bounded(bz2.BZ2Decompressor), lz4=_bounded(lz4_frame))


def unpack_message(data: bytes) -> bytes:
    """A message that was packed by zstd on its own; `Oversized` when no recorder can have packed it."""
    return _bounded(zstd().ZstdDecompressor)(data)


def _bounded(make: Callable[[], Any]) -> Callable[[bytes], bytes]:
    def unpack(data: bytes) -> bytes:
        unpacked = _first(make, data, MAX_BYTES + 1)
        _check_size(len(unpacked))
        return unpacked

    return unpack


def _of_size(make: Callable[[], Any]) -> Callable[[bytes, int], bytes]:
    """Unpack to the stated size, or one byte more by which rosbags sees that it is wrong."""

    def unpack(data: bytes, size: int) -> bytes:
        _check_size(size)
        return _first(make, data, size + 1)

    return unpack


def _first(make: Callable[[], Any], data: bytes, most: int) -> bytes:
    """At most that many bytes of what `data` unpacks to; bz2, lz4 and zstd share the interface."""
    unpacker = make()
    unpacked: bytes = unpacker.decompress(data, max_length=most)
    if len(unpacked) < most and not unpacker.eof:
        raise EOFError("a compressed part is cut off")
    return unpacked


def _check_size(size: int) -> None:
    if size > MAX_BYTES:
        raise Oversized(
            f"has a part that unpacks to more than {MAX_BYTES // 10**6} MB, which no recorder writes;"
            " convert it by `ros2 bag convert`, or record it again"
        )


def _check_packed(path: Path) -> None:
    """Refuse a file that rosbags would unpack to a temporary one far larger; `Oversized`."""
    most = max(SWELL * path.stat().st_size, MAX_BYTES)
    size = 0
    with zstd().open(path) as stream:
        while block := stream.read(2**20):
            if (size := size + len(block)) > most:
                raise Oversized(
                    f"has a part, {path.name}, that unpacks to more than {most / 1e6:.0f} MB, {SWELL} times its size;"
                    " unpack it by `zstd -d` if that is right, and name the file"
                )

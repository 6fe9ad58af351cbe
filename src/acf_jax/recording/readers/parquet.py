"""Parquet tables, through pyarrow."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from acf_jax.errors import InputError, shown
from acf_jax.recording.readers._guard import Faults, border, need, within
from acf_jax.recording.readers._table import Chunk, Table
from acf_jax.recording.series import Channel, Progress

KIND = "a Parquet table (.parquet)"
SUFFIXES = (".parquet", ".pq")
ROWS = 65_536  # of a chunk
_REMEDY = "the file is damaged or not closed; write it again"


def recognises(path: Path) -> bool:
    """A file of one of the suffixes."""
    return path.is_file() and path.suffix.lower() in SUFFIXES


def open_recording(path: Path, time: str | None, time_scale: float | None) -> Table:
    """The table, by its schema."""
    parquet: Any = need("pyarrow.parquet", "parquet", f"{path}: reading Parquet")
    import pyarrow

    faults: Faults = (pyarrow.ArrowException, OSError, ValueError, TypeError, LookupError, MemoryError)
    with border(path, faults, _REMEDY):
        file = parquet.ParquetFile(path)
        schema, rows = file.schema_arrow, file.metadata.num_rows
        columns = [Channel(field.name, str(field.type), rows) for field in schema]
        file.close()
    if twice := [name for name in dict.fromkeys(schema.names) if schema.names.count(name) > 1]:
        raise InputError(
            f"{path} column {shown(twice[0])}: is there twice; give each column a name of its own"
        )

    def chunks(wanted: Sequence[str], progress: Progress) -> Iterator[Chunk]:
        with border(path, faults, _REMEDY):
            file = parquet.ParquetFile(path)
            batches = file.iter_batches(batch_size=ROWS, columns=list(wanted))
        done = 0
        with file:
            for batch in within(batches, path, faults, _REMEDY):
                with border(path, faults, _REMEDY):
                    chunk = {name: _numbers(path, name, batch.column(name)) for name in wanted}
                yield chunk
                done += batch.num_rows
                progress(done, rows)

    return Table(path, columns, chunks, time, time_scale)


def _numbers(path: Path, name: str, column: Any) -> Any:
    """A column as NumPy numbers, NaN (NaT for times) where it is null."""
    import pyarrow
    from pyarrow import types

    if types.is_timestamp(column.type):
        return column.cast(pyarrow.timestamp("ns")).to_numpy(zero_copy_only=False)
    if types.is_integer(column.type) and not column.null_count:
        return column.to_numpy(zero_copy_only=False)
    if not (types.is_integer(column.type) or types.is_floating(column.type) or types.is_decimal(column.type)):
        raise InputError(
            f"{path} column {shown(name)}: holds {column.type}, not numbers; name another column"
        )
    return column.cast(pyarrow.float64()).to_numpy(zero_copy_only=False)

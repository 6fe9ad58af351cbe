"""Parquet tables, through pyarrow."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from acf_jax.errors import InputError, shown
from acf_jax.recording.mapping import Mapping
from acf_jax.recording.readers._bounds import check_rows, check_unpacked
from acf_jax.recording.readers._guard import Faults, border, need, within
from acf_jax.recording.readers._table import Chunk, Table, unique
from acf_jax.recording.series import Channel, Progress

KIND = "a Parquet table (.parquet)"
SUFFIXES = (".parquet", ".pq")
ROWS = 65_536  # of a chunk
_REMEDY = "the file is damaged or not closed; write it again"


def recognises(path: Path) -> bool:
    """A file of one of the suffixes."""
    return path.is_file() and path.suffix.lower() in SUFFIXES


def open_recording(path: Path, stated: Mapping) -> Table:
    """The table, by its schema."""
    parquet: Any = need("pyarrow.parquet", "parquet", f"{path}: reading Parquet")
    import pyarrow

    faults: Faults = (pyarrow.ArrowException, OSError, ValueError, TypeError, LookupError, MemoryError)
    with border(path, faults, _REMEDY), parquet.ParquetFile(path) as file:
        schema, rows = file.schema_arrow, file.metadata.num_rows
    names = unique(schema.names)
    columns = [Channel(name, str(field.type), rows) for name, field in zip(names, schema, strict=True)]

    def chunks(wanted: Sequence[str], progress: Progress) -> Iterator[Chunk]:
        places = [names.index(name) for name in wanted]
        own = [schema.names[place] for place in places]
        # of columns called the same, a batch holds all
        alike = [schema.names[:place].count(schema.names[place]) for place in places]
        check_rows(path, rows)
        with border(path, faults, _REMEDY):
            file = parquet.ParquetFile(path)
            check_unpacked(path, _unpacked(file.metadata, set(own)))
            batches = file.iter_batches(batch_size=ROWS, columns=list(dict.fromkeys(own)))
        done = 0
        with file:
            for batch in within(batches, path, faults, _REMEDY):
                with border(path, faults, _REMEDY):
                    held = [
                        batch.schema.get_all_field_indices(name)[i]
                        for name, i in zip(own, alike, strict=True)
                    ]
                    chunk = {n: _numbers(path, n, batch.column(i)) for n, i in zip(wanted, held, strict=True)}
                yield chunk
                done += batch.num_rows
                progress(done, rows)

    return Table(path, columns, chunks, stated)


def _unpacked(metadata: Any, names: set[str]) -> int:
    """Bytes that the columns `names` say to take."""
    groups = [metadata.row_group(i) for i in range(metadata.num_row_groups)]
    columns = [group.column(j) for group in groups for j in range(group.num_columns)]
    return sum(column.total_uncompressed_size for column in columns if column.path_in_schema in names)


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
    try:
        return column.cast(pyarrow.float64()).to_numpy(zero_copy_only=False)
    except pyarrow.ArrowInvalid:  # beyond 2^53, as ns since 1970
        what = "lacks a value beside whole numbers too large to be exact with one missing"
        raise InputError(f"{path} column {shown(name)}: {what}; fill it, or leave out its row") from None

"""Text tables, whatever separates their cells and stands before them."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from acf_jax.recording.mapping import Mapping
from acf_jax.recording.readers import lvm
from acf_jax.recording.readers._cells import chunks
from acf_jax.recording.readers._layout import find_layout
from acf_jax.recording.readers._table import Chunk, Table, unique
from acf_jax.recording.readers._text import Text, is_called_text
from acf_jax.recording.series import Channel, Progress

KIND = "a text table (.csv, .tsv, .txt, .dat, .asc, .prn, .log, also .gz)"


def recognises(path: Path) -> bool:
    """A text that LabVIEW has not written."""
    return is_called_text(path) and path.is_file() and not lvm.recognises(path)


def open_recording(path: Path, stated: Mapping) -> Table:
    """The table, its separator and header found by the rows of numbers."""
    text = Text(path)
    layout = find_layout(path, text.head())
    names = unique(layout.names)

    def read(wanted: Sequence[str], progress: Progress) -> Iterator[Chunk]:
        return chunks(text, layout, names, wanted, progress)

    columns = [Channel(name, "column") for name in names]
    units = dict(zip(names, layout.units, strict=False))
    return Table(
        path,
        columns,
        read,
        stated,
        units=units,
        notes=[*text.notes, *layout.notes(path)],
        fault=layout.fault(path) or text.fault,
    )

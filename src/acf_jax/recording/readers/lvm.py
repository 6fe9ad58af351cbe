"""LabVIEW measurement files: text with two headers, channels by column."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from acf_jax.errors import InputError
from acf_jax.recording.mapping import Mapping
from acf_jax.recording.readers._cells import chunks
from acf_jax.recording.readers._layout import Layout
from acf_jax.recording.readers._table import Chunk, Table, unique
from acf_jax.recording.readers._text import Text, is_called_text
from acf_jax.recording.readers._times import Step
from acf_jax.recording.series import Channel, Progress

KIND = "a LabVIEW measurement (.lvm, also .gz and renamed)"
_BEGIN, _END, _TIME = "LabVIEW Measurement", "***End_of_Header***", "X_Value"
_REMEDY = "save it again from LabVIEW, or as a table with a header"


def recognises(path: Path) -> bool:
    """A text that begins as LabVIEW's do, whatever its name; one without headers is a table."""
    if not (is_called_text(path) and path.is_file()):
        return False
    try:
        return Text(path).head()[0].startswith(_BEGIN)
    except InputError:
        return False


class _Measurement(Text):
    """A text of one measurement."""

    def blocks(self) -> Iterator[str]:
        """The text; `InputError` where another measurement begins."""
        ends = 0
        for text in super().blocks():
            ends += text.count(_END)
            if ends > 2:
                raise InputError(f"{self.path}: holds several measurements; save each in a file of its own")
            yield text


def open_recording(path: Path, stated: Mapping) -> Table:
    """The channels; times are those of X_Value, or come from X0 and Delta_X where that column is empty."""
    text = _Measurement(path)
    lines = text.head()
    ends = [i for i, line in enumerate(lines) if line.startswith(_END)]
    place = next((i for i in range(ends[-1] + 1, len(lines)) if lines[i].strip()), None) if ends else None
    if place is None:
        raise InputError(f"{path}: has no line {_END} with data after it; {_REMEDY}")
    separator = (
        "," if _values(lines, "Separator", "\t")[:1] == ["Comma"] or "\t" not in lines[place] else "\t"
    )
    header = [cell.strip() for cell in lines[place].rstrip(separator).split(separator)]
    if header[-1] == "Comment":  # rows need not have it
        header.pop()
    names = unique(header)
    skip = place + 1
    rows = [line.split(separator) for line in lines[skip : skip + 2]]
    # a remark stands in the first row, if anywhere
    layout = Layout(separator, names, skip, len(rows[-1]) if rows else 0, remarks=True)

    def read(wanted: Sequence[str], progress: Progress) -> Iterator[Chunk]:
        return chunks(text, layout, names, wanted, progress)

    times = [name for name, cell in zip(names, header, strict=True) if cell == _TIME]
    channels = [name for name in names if name not in times]
    steps = {} if rows and rows[0][0].strip() else _steps(path, lines, separator, channels)
    units = dict.fromkeys(times, "s")
    return Table(
        path,
        [Channel(name, "column") for name in names],
        read,
        stated,
        units=units,
        steps=steps,
        notes=text.notes,
        fault=text.fault,
    )


def _values(lines: Sequence[str], key: str, separator: str) -> list[str]:
    """What a header says of a key, the last header first."""
    found = [line for line in lines if line.startswith(key + separator)]
    return [cell.strip() for cell in found[-1].split(separator)[1:] if cell.strip()] if found else []


def _steps(path: Path, lines: Sequence[str], separator: str, channels: Sequence[str]) -> dict[str, Step]:
    """First time and interval of each channel."""
    try:
        starts, steps = (
            [float(cell.replace(",", ".")) for cell in _values(lines, key, separator)]
            for key in ("X0", "Delta_X")
        )
    except ValueError:
        raise InputError(f"{path}: X0 or Delta_X holds no numbers; {_REMEDY}") from None
    starts = starts or [0.0] * len(steps)
    return {
        name: Step(round(1e9 * start), step)
        for name, start, step in zip(channels, starts, steps, strict=False)
        if step > 0
    }

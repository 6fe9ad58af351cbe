"""LabVIEW's TDMS files, through npTDMS: groups of channels, each with its own sampling interval or none."""

import logging
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acf_jax.errors import InputError, shown
from acf_jax.recording.mapping import Mapping
from acf_jax.recording.readers._bounds import check_rows
from acf_jax.recording.readers._guard import Faults, border, need
from acf_jax.recording.readers._table import Chunk, Table, unique
from acf_jax.recording.readers._times import Step
from acf_jax.recording.series import Channel, Progress

KIND = "a LabVIEW TDMS file (.tdms)"
ROWS = 1_000_000  # of a chunk
# npTDMS uses what a damaged file says before it checks it.
_FAULTS: Faults = (OSError, ValueError, LookupError, TypeError, AttributeError, ArithmeticError, struct.error,
                   NotImplementedError, RuntimeError, MemoryError)  # fmt: skip
_REMEDY = "the file is damaged or not closed; save it again from LabVIEW"


def recognises(path: Path) -> bool:
    """A file of the suffix."""
    return path.is_file() and path.suffix.lower() == ".tdms"


def open_recording(path: Path, stated: Mapping) -> Table:
    """The channels, GROUP/CHANNEL where there are several groups; an interval of theirs gives their times."""
    nptdms: Any = need("nptdms", "tdms", f"{path}: reading TDMS")
    nptdms.log.log_manager.set_level(logging.ERROR)  # it would write warnings between the lines of a user
    with border(path, _FAULTS, _REMEDY), nptdms.TdmsFile.read_metadata(path) as file:
        groups = [group for group in file.groups() if group.channels()]
        channels = [channel for group in groups for channel in group.channels()]
        keys = [(channel.group_name, channel.name) for channel in channels]
        names = unique([name if len(groups) == 1 else f"{group}/{name}" for group, name in keys])
        columns = [Channel(n, str(c.dtype), len(c)) for n, c in zip(names, channels, strict=True)]
        whole = not file.file_status.incomplete_final_segment
        steps = _steps(names, [dict(channel.properties) for channel in channels])

    def chunks(wanted: Sequence[str], progress: Progress) -> Iterator[Chunk]:
        places = [names.index(name) for name in wanted]
        counts = {columns[place].name: columns[place].count or 0 for place in places}
        size = min(counts.values())  # the last channels of a file that was not closed are shorter
        check_rows(path, size)
        if whole and len(set(counts.values())) > 1:
            listed = ", ".join(f"{shown(name)} {count}" for name, count in counts.items())
            raise InputError(
                f"{path}: the channels {listed} must be of one length; name a time of each in --mapping"
            )
        with border(path, _FAULTS, _REMEDY):
            file = nptdms.TdmsFile.open(path, raw_timestamps=True)
        with file:
            for first in range(0, max(size, 1), ROWS):
                with border(path, _FAULTS, _REMEDY):
                    parts = [file[keys[place][0]][keys[place][1]] for place in places]
                    values = [_numbers(part.read_data(first, min(ROWS, size - first))) for part in parts]
                yield dict(zip(wanted, values, strict=True))
                progress(min(first + ROWS, size), size)

    notes = [] if whole else [f"{path}: was not closed; its last samples are missing"]
    return Table(path, columns, chunks, stated, steps=steps, notes=notes)


def _numbers(values: Any) -> NDArray[np.generic]:
    """Numbers, or dates from LabVIEW's timestamps."""
    return values.as_datetime64("ns") if hasattr(values, "as_datetime64") else np.asarray(values)


def _steps(names: Sequence[str], properties: Sequence[dict[str, Any]]) -> dict[str, Step]:
    """First time and interval of each waveform, absolute where all of them are."""
    waves = {
        name: found
        for name, found in zip(names, properties, strict=True)
        if isinstance(found.get("wf_increment"), float) and found["wf_increment"] > 0
    }
    starts = [found.get("wf_start_time") for found in waves.values()]
    absolute = all(isinstance(start, np.datetime64) for start in starts)
    return {
        name: Step(
            round(1e9 * float(found.get("wf_start_offset", 0.0)))
            + (int(found["wf_start_time"].astype("datetime64[ns]").astype(np.int64)) if absolute else 0),
            found["wf_increment"],
        )
        for name, found in waves.items()
    }

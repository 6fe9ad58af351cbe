"""A recording as three signals on one clock: force, robot speed or position, pretension."""

from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from acf_jax.errors import InputError
from acf_jax.recording.choose import choose
from acf_jax.recording.clock import settle, to_clock_of
from acf_jax.recording.mapping import Mapping, Source
from acf_jax.recording.readers import open_recording
from acf_jax.recording.series import Progress, Series, in_order


@dataclass(frozen=True)
class Session:
    """What a recording says of its impacts."""

    path: Path
    force: Series  # N
    speed: Series | float  # m/s, or m where it is a position
    is_position: bool
    pretension: Series | float  # N
    labels: dict[str, str]  # what each role is called in the recording
    notes: tuple[str, ...]  # what a user should know

    @property
    def duration(self) -> float:
        """Of the force signal, s."""
        return float(self.force.time[-1] - self.force.time[0]) * 1e-9


def read_session(path: Path, mapping: Mapping, progress: Progress = lambda done, total: None) -> Session:
    """Read the signals that a mapping names, or the only candidates, and bring them to the clock of the force.

    **Raises:** `InputError` when the recording cannot be read, or a signal has to be named.
    """
    with closing(open_recording(path, mapping)) as recording:
        chosen = choose(path, recording, mapping)
        labels = {role: recording.described(source) for role, source in chosen.sources.items()}
        raw = recording.read(chosen.sources, progress)
    faults, ready = [], {}
    for role, source in chosen.sources.items():
        try:
            series = in_order(settle(raw.pop(role), labels[role]), f"{path} {labels[role]}")
        except InputError as error:
            faults += error.faults
        else:
            ready[role] = _scaled(series, source)
    if faults:
        raise InputError(faults)
    force = ready["force"]
    for role in ready.keys() - {"force"}:
        if "clock_offset_s" not in chosen.sources[role].model_fields_set:  # a stated offset counts
            try:
                ready[role] = to_clock_of(ready[role], force, labels[role])
            except InputError as error:
                raise InputError([f"{path} {fault}" for fault in error.faults]) from None
    notes = [*chosen.notes, *(note for series in ready.values() for note in series.notes)]
    return Session(
        path=path,
        force=force,
        speed=ready["speed"] if "speed" in ready else _number(chosen.speed),
        is_position=chosen.is_position,
        pretension=ready["pretension"] if "pretension" in ready else _number(chosen.pretension),
        labels=labels,
        notes=tuple(dict.fromkeys(notes)),
    )


def _scaled(series: Series, source: Source) -> Series:
    shift = np.int64(round(1e9 * source.clock_offset_s))
    time = series.time + shift if shift else series.time
    return replace(
        series, time=time, value=series.value * source.scale if source.scale != 1.0 else series.value
    )


def _number(value: Source | float) -> float:
    assert isinstance(value, float)
    return value

"""A recording as three signals: force, robot speed or position, pretension; on one clock where that is known."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from acf_jax.errors import InputError
from acf_jax.provenance import digest_of
from acf_jax.recording.choose import Chosen, choose
from acf_jax.recording.clock import settle, to_clock_of
from acf_jax.recording.mapping import Mapping, Source
from acf_jax.recording.opened import open_session
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
    scales: dict[str, float] = field(default_factory=dict)  # before the names or by their units, by role
    elsewhere: dict[str, int] = field(default_factory=dict)  # which other recording a role is read from
    apart: frozenset[str] = frozenset()  # those of them whose clock is not known to be that of the force
    others: tuple[Path, ...] = ()  # further recordings
    clock_std: float = 0.0  # s, of where the speed lies on the clock of the force

    @property
    def duration(self) -> float:
        """Of the force signal, s."""
        return float(self.force.time[-1] - self.force.time[0]) * 1e-9

    def digests(self) -> dict[str, str]:
        """SHA-256 of each recording behind it, by its path."""
        return {str(path): digest_of(path) for path in dict.fromkeys([self.path, *self.others])}

    def where(self, role: str) -> str:
        """File and signal in words, for messages."""
        if role in self.elsewhere:
            return self.labels[role]
        return f"{self.path} {self.labels.get(role, '--velocity' if role == 'speed' else f'--{role}')}"

    def remedy(self, role: str, factor: float) -> str:
        """How to multiply a signal by `factor`, from what stands before its name already."""
        number = {"speed": self.speed, "pretension": self.pretension}.get(role)
        if isinstance(number, float) and role not in self.labels:
            return f"give {factor * number:.3g} {'m/s' if role == 'speed' else 'N'}"
        scale = self.scales.get(role, 1.0)
        if scale == 1.0:
            return f"put {factor:g}* before its name"
        if np.isclose(scale * factor, 1.0):
            was = "its sign was turned" if scale == -1.0 else "it was scaled"
            return f"{was} by {scale:g}*: take {scale:g}* away"
        was = f", since its sign was turned by {scale:g}*" if scale < 0.0 > factor else ""
        return f"put {scale * factor:g}* before its name in place of {scale:g}*{was}"


def read_session(
    path: Path,
    mapping: Mapping,
    progress: Progress = lambda done, total: None,
    other: Path | None = None,
) -> Session:
    """Read the signals that a mapping names, or the only candidates, and bring them to the clock of the force.

    **Arguments:** `path`: the recording of the force. `other`: where the robot's signals are, if not there.

    **Raises:** `InputError` when a recording cannot be read, or a signal has to be named.
    """
    with open_session(path, mapping, other) as opened:
        chosen = choose(opened, mapping)
        places, sources = chosen.places, chosen.sources
        labels = {role: opened[places[role]].described(source) for role, source in sources.items()}
        others = tuple(one.path for one in opened if not one.is_first)
        raw: dict[str, Series] = {}
        for place, one in enumerate(opened):
            if own := {role: source for role, source in sources.items() if places[role] == place}:
                raw |= one.recording.read(own, progress)
    faults, ready, offsets = [], {}, {}
    for role, source in sources.items():
        where = labels[role] if places[role] else f"{path} {labels[role]}"
        try:
            series = in_order(settle(raw.pop(role), labels[role]), where)
        except InputError as error:
            faults += error.faults
        else:
            offsets[role] = _offset(role, chosen, series)
            ready[role] = _scaled(series, source, offsets[role])
    if faults:
        raise InputError(faults)
    free = {role for role in ready if role != "force" and offsets[role] is None}  # a stated offset counts
    for role in sorted(free):
        try:
            ready[role] = to_clock_of(ready[role], ready["force"], labels[role])
        except InputError as error:
            where = "" if places[role] else f"{path} "
            raise InputError([f"{where}{fault}" for fault in error.faults]) from None
    notes = [*chosen.notes, *(note for series in ready.values() for note in series.notes)]
    return Session(
        path=path,
        force=ready["force"],
        speed=ready.get("speed", _number(chosen.speed)),
        is_position=chosen.is_position,
        pretension=ready.get("pretension", _number(chosen.pretension)),
        labels=labels,
        notes=tuple(dict.fromkeys(notes)),
        scales={role: source.scale for role, source in sources.items()},
        elsewhere={role: place for role, place in places.items() if place},
        others=others,
        apart=frozenset(role for role in free if places[role]),
    )


def _offset(role: str, chosen: Chosen, series: Series) -> float | None:
    """The offset that is stated for a signal, or for another column of the same further table: it has one clock."""
    source = chosen.sources[role]
    if "clock_offset_s" in source.model_fields_set:
        return source.clock_offset_s
    place = chosen.places[role]
    beside = {
        s.clock_offset_s
        for other, s in chosen.sources.items()
        if place and chosen.places[other] == place and "clock_offset_s" in s.model_fields_set
    }
    return beside.pop() if series.received is None and len(beside) == 1 else None


def _scaled(series: Series, source: Source, offset: float | None) -> Series:
    time = series.time + np.int64(round(1e9 * offset)) if offset else series.time
    value = series.value * source.scale if source.scale != 1.0 else series.value
    return replace(series, time=time, value=value)


def _number(value: Source | float) -> float:
    return value if isinstance(value, float) else np.nan  # a signal, which is read

"""The recordings of one session: that of the force, and those that hold the robot's signals, each by its own times."""

import os
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

from acf_jax.errors import InputError
from acf_jax.recording.mapping import Mapping, Source
from acf_jax.recording.readers import Recording, open_recording


@dataclass(frozen=True)
class Opened:
    """An open recording."""

    path: Path
    recording: Recording
    is_first: bool

    def described(self, source: Source) -> str:
        """A signal in words, with its file where that is not the first."""
        name = self.recording.described(source)
        return name if self.is_first else f"{self.path} {name}"


@contextmanager
def open_session(path: Path, mapping: Mapping, other: Path | None) -> Iterator[list[Opened]]:
    """The recording in `path`, then `other`, then those that signals of the mapping name, from the folder of `path`.

    **Raises:** `InputError` when one cannot be opened.
    """
    sources = [s for s in (mapping.velocity, mapping.position, mapping.pretension) if isinstance(s, Source)]
    named = [(path.parent / s.recording, s) for s in sources if s.recording is not None]
    if other is not None and is_same(other, path):
        raise InputError(f"--with {other}: is the recording itself; name that of the robot, or leave it out")
    with ExitStack() as stack:
        first = open_recording(path, mapping)
        opened = [Opened(path, stack.enter_context(closing(first)), True)]
        for one in (*([other] if other else []), *(found for found, _ in named)):
            if not any(is_same(one, had.path) for had in opened):
                source = next((source for found, source in named if is_same(found, one)), None)
                recording = _open_other(one, mapping, source)
                opened.append(Opened(one, stack.enter_context(closing(recording)), False))
        yield opened


def is_same(one: Path, other: Path) -> bool:
    """Whether two paths lead to one file."""
    return os.path.realpath(one) == os.path.realpath(other)


def _open_other(path: Path, mapping: Mapping, source: Source | None) -> Recording:
    """A further recording, its times as a signal in it states, else as those of the first, else as its kind tells."""
    if source is not None and (source.time or source.time_scale):
        return open_recording(path, Mapping(time=source.time, time_scale=source.time_scale))
    recording = open_recording(path)
    if mapping.time is None or mapping.time not in {channel.name for channel in recording.channels()}:
        return recording
    recording.close()
    return open_recording(path, Mapping(time=mapping.time, time_scale=mapping.time_scale))

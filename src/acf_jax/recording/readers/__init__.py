"""Recordings by kind, one reader a file: a new file here is a new kind."""

import importlib
import pkgutil
from collections.abc import Mapping
from pathlib import Path
from typing import Protocol, cast

from acf_jax.errors import InputError
from acf_jax.files import check_ordinary
from acf_jax.recording.mapping import Mapping as Stated
from acf_jax.recording.mapping import Source
from acf_jax.recording.series import Channel, Progress, Series


class Recording(Protocol):
    """An open recording."""

    def close(self) -> None:
        """Let go of the file."""

    def channels(self) -> list[Channel]:
        """What it offers, by name."""

    def numbers(self, name: str) -> list[str]:
        """The fields of a channel that hold numbers; none where the channel itself does."""

    def obstacles(self) -> list[str]:
        """What has to be mended or named beside the signals, such as the time of a table."""

    def candidates(self, role: str) -> list[Source]:
        """What may be the 'force', the 'velocity' (or the position) or the 'pretension', most telling names only."""

    def is_position(self, source: Source) -> bool:
        """Whether a signal is, by its kind, a position rather than a velocity."""

    def unit(self, source: Source) -> str:
        """The unit that is stated of a signal; empty where none is."""

    def described(self, source: Source) -> str:
        """The signal in words, its field filled in."""

    def read(self, sources: Mapping[str, Source], progress: Progress) -> dict[str, Series]:
        """The samples of several signals in one pass, by the keys of `sources`; `InputError` where one is missing."""


class Reader(Protocol):
    """A module of this folder."""

    KIND: str  # in words

    def recognises(self, path: Path) -> bool:
        """Whether a file or folder is of this kind, by suffix and content."""

    def open_recording(self, path: Path, stated: Stated) -> Recording:
        """The recording; `InputError` when it cannot be opened. `stated`: what the user says of it."""


def readers() -> list[Reader]:
    """Every reader, in the order of their names."""
    names = sorted(m.name for m in pkgutil.iter_modules(__path__) if not m.name.startswith("_"))
    return [cast(Reader, importlib.import_module(f"{__name__}.{name}")) for name in names]


def open_recording(path: Path, stated: Stated | None = None) -> Recording:
    """The recording in a file or folder, by the reader that knows its kind; `stated` is what the user says of it.

    **Raises:** `InputError` when there is none, or when none knows it.
    """
    if not path.exists():
        raise InputError(f"{path}: no such file or folder; check the path")
    if not path.is_dir():
        check_ordinary(path, None)  # of any size: readers stream
    known = readers()
    for reader in known:
        if reader.recognises(path):
            return reader.open_recording(path, stated or Stated())
    raise InputError(f"{path}: is no recording known here; name one of {', '.join(r.KIND for r in known)}")

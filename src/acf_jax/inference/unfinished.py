"""Fits of a diagnosis that is not finished: kept on the disk, so that one that was interrupted goes on where it was.

A fit depends on nothing but its arguments and this program. Where its optimum is known already, one simulation gives
the fit anew, to the last digit.
"""

import dataclasses
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from acf_jax.errors import InputError
from acf_jax.files import write_bytes
from acf_jax.kept import origin

MADE_OF = ("model", "effects", "simulator", "dataset", "inference")  # whose source a fit depends on
_folder: Path | None = None  # of this process: fits end in several threads


def beside(out: Path) -> Path:
    """Where the fits of a diagnosis are kept that is not yet written to `out`."""
    target = out.resolve()
    return target.with_name(f".{target.name}.unfinished")


@contextmanager
def kept_in(folder: Path) -> Iterator[int]:
    """Keep fits in a folder until the block ends well; yields how many an interrupted run has left there.

    A folder that cannot be written costs the fits, nothing else.
    """
    global _folder
    before, _folder = _folder, folder
    try:
        yield sum(1 for _ in folder.glob("*.npz"))
    finally:
        _folder = before
    shutil.rmtree(folder, ignore_errors=True)


def key_of(*arguments: Any) -> str | None:
    """What tells a fit from every other; None where none is kept."""
    return digest((origin(MADE_OF), arguments)) if _folder else None


def find(key: str | None) -> tuple[np.ndarray, np.ndarray] | None:
    """Parameters and nuisances at the optimum, in prior standard deviations; None where they are not known."""
    if _folder is None or key is None:
        return None
    try:
        stored = BytesIO((_folder / f"{key}.npz").read_bytes())
        with np.load(stored, allow_pickle=False) as content:
            return content["u"], content["nuisance"]
    except (OSError, LookupError, ValueError, EOFError, BadZipFile):
        return None


def keep(key: str | None, u: np.ndarray, nuisance: np.ndarray) -> None:
    """Write what `find` reads."""
    if _folder is None or key is None:
        return
    content = BytesIO()
    np.savez(content, u=u, nuisance=nuisance)
    with suppress(OSError, InputError):
        write_bytes(_folder / f"{key}.npz", content.getvalue())


def digest(value: Any) -> str:
    """SHA-256 of numbers, texts and arrays, in tuples and dataclasses of any depth."""
    if isinstance(value, np.ndarray):
        value = np.ascontiguousarray(value)
        return sha256(f"{value.dtype}{value.shape}".encode() + value.tobytes()).hexdigest()
    if dataclasses.is_dataclass(value):
        value = (type(value).__name__, *(getattr(value, field.name) for field in dataclasses.fields(value)))
    if isinstance(value, tuple | list):
        return sha256(" ".join(map(digest, value)).encode()).hexdigest()
    return sha256(repr(value).encode()).hexdigest()

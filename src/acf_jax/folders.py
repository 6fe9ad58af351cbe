"""Folders that are written as a whole: all files of a run, or all that were there before."""

import glob
import json
import os
import shutil
import signal
import sys
import tempfile
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

if sys.platform != "win32":
    import fcntl

# In a scratch folder: files while they are written, once all are, those of the earlier run, and names of its others.
NEW, WHOLE, OLD, STALE = "new", "whole", "old", "stale.json"
LOCK = "acf-jax.lock"  # held as long as the run lives


@contextmanager
def whole_folder(target: Path, stale: Iterable[str] = ()) -> Iterator[Path]:
    """A scratch folder whose files move into `target` when the block ends well, and vanish otherwise.

    Files that are in `target` already stay, but for those of the same names and for `stale`: what an earlier run left
    there, by paths in `target`. Neither Ctrl-C nor a fault in the middle leaves files of two runs side by side, and
    `recover` completes the moves of a run that was killed.
    """
    target = target.resolve()
    target.parent.mkdir(parents=True, exist_ok=True)
    recover(target)
    # beside a new folder, but within one that is there: it may be the root of another file system
    beside = target if target.is_dir() else target.parent
    scratch = Path(tempfile.mkdtemp(dir=beside, prefix=f".{target.name}."))
    new = scratch / NEW
    try:
        with _claim(scratch, create=True):
            new.mkdir()
            yield new
            if not target.exists():
                new.rename(target)
                return
            (scratch / STALE).write_text(json.dumps(list(stale)))
            with _without_interrupt():
                os.replace(new, scratch / WHOLE)  # from here on a run that is killed is completed
                _move(_moves(scratch, target))
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def recover(target: Path) -> None:
    """Complete the moves into `target` of a run that was killed in their middle, and remove what such runs left.

    Until its first move a run has changed nothing in `target`; from then on all that it wrote is there. What a run
    that still lives works on stays.
    """
    target = target.resolve()
    for folder in (target, target.parent):
        for scratch in sorted(folder.glob(f".{glob.escape(target.name)}.*")):
            if not (scratch / LOCK).is_file() or not any((scratch / part).is_dir() for part in (NEW, WHOLE)):
                continue
            with _claim(scratch) as is_left:
                if is_left:
                    if (scratch / WHOLE).is_dir() and target.is_dir():
                        with _without_interrupt():
                            _move(_moves(scratch, target))
                    shutil.rmtree(scratch, ignore_errors=True)


def _moves(scratch: Path, target: Path) -> list[tuple[Path, Path]]:
    """The moves that are left: files of the earlier run aside, then those of this one into their places.

    None leads out of `target`: what lies in its scratch folders may have come with the data of others.
    """
    whole, old = scratch / WHOLE, scratch / OLD
    files = [path.relative_to(whole) for path in sorted(whole.rglob("*")) if path.is_file()]
    try:
        stale = [Path(name) for name in json.loads((scratch / STALE).read_text())]
    except (OSError, TypeError, ValueError):
        stale = []
    named = dict.fromkeys([*files, *stale])
    within = {name for name in named if (target / name).resolve().is_relative_to(target)}
    aside = [
        (target / name, old / name)
        for name in named
        if name in within and (target / name).is_file() and not (old / name).exists()
    ]
    return [*aside, *((whole / name, target / name) for name in files if name in within)]


@contextmanager
def _claim(scratch: Path, create: bool = False) -> Iterator[bool]:
    """Whether the scratch folder is nobody else's: the system frees the lock of a process that died."""
    if sys.platform == "win32":  # has no such locks: nothing is claimed there
        yield False
        return
    with (scratch / LOCK).open("w" if create else "r") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            yield False
        else:
            yield True


def _move(moves: Iterable[tuple[Path, Path]]) -> None:
    """Rename files one by one; all go back where one cannot be renamed."""
    done = []
    try:
        for source, destination in moves:
            destination.parent.mkdir(parents=True, exist_ok=True)
            os.replace(source, destination)
            done.append((source, destination))
    except BaseException:
        for source, destination in reversed(done):
            os.replace(destination, source)
        raise


@contextmanager
def _without_interrupt() -> Iterator[None]:
    """Ctrl-C counts when the block is done; only the main thread ever sees it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, frame: came.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        if came:
            signal.raise_signal(signal.SIGINT)


def read_folder(folder: Path) -> dict[str, bytes]:
    """The files of a folder by their paths in it."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def write_folder(folder: Path, files: dict[str, bytes]) -> None:
    """Write files by their paths into `folder`, all or none."""
    with whole_folder(folder) as scratch:
        for name, content in files.items():
            (scratch / name).parent.mkdir(parents=True, exist_ok=True)
            (scratch / name).write_bytes(content)

"""Folders that are written as a whole: all files of a run, or all that were there before."""

import os
import shutil
import signal
import tempfile
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole_folder(target: Path, stale: Iterable[str] = ()) -> Iterator[Path]:
    """A scratch folder whose files move into `target` when the block ends well, and vanish otherwise.

    Files that are in `target` already stay, but for those of the same names and for `stale`: what an earlier run left
    there, by paths in `target`. Neither Ctrl-C nor a fault in the middle leaves files of two runs side by side.
    """
    target = target.resolve()
    target.parent.mkdir(parents=True, exist_ok=True)
    # beside a new folder, but within one that is there: it may be the root of another file system
    beside = target if target.is_dir() else target.parent
    scratch = Path(tempfile.mkdtemp(dir=beside, prefix=f".{target.name}."))
    new, old = scratch / "new", scratch / "old"
    try:
        new.mkdir()
        yield new
        if not target.exists():
            new.rename(target)
            return
        files = [path.relative_to(new) for path in sorted(new.rglob("*")) if path.is_file()]
        gone = [name for name in dict.fromkeys([*files, *map(Path, stale)]) if (target / name).is_file()]
        aside = [(target / name, old / name) for name in gone]
        with _without_interrupt():
            _move([*aside, *((new / name, target / name) for name in files)])
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


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

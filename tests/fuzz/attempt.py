"""One attempt: files that went wrong are read, and are understood or refused; nothing else may happen.

Else is: another error; no end within `LONGEST`; more than `MOST` of memory; a message of several lines, without
remedy or without end; a refusal that leaves a file behind; a number in what was understood that is none.
"""

import dataclasses
import faulthandler
import os
import resource
import signal
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple

import jax
import numpy as np

from acf_jax.errors import InputError
from tests.fuzz.hostile import SPARSE, Sparse
from tests.fuzz.readers import Files, Reader

LONGEST = 60  # s of processor time; a file of the largest size that is read takes up to 14 on a slow machine
PATIENCE = 5  # times as long by the clock, on a busy machine
MOST = 1_500_000_000  # bytes in memory beyond what was there before; twice as much as the largest bound on files allows
_STATUS, _RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")  # of Linux


class Hang(AssertionError):
    """A reader that does not come to an end."""


class Outcome(NamedTuple):
    """What came of an attempt."""

    faults: list[str]  # none where the files were understood
    seconds: float
    memory: int  # bytes; 0 where the system does not tell


def attempt(reader: Reader, files: Files, longest: int = LONGEST) -> Outcome:
    """What came of reading the files; `AssertionError` or whatever the reader raises for what must not be."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for relative, content in files.items():
            path = folder / relative
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
            if isinstance(content, Sparse):
                os.truncate(path, SPARSE)
        faults: list[str] = []
        start = time.process_time()
        with _at_most(longest), _memory() as used:
            try:
                found = reader.read(folder)
            except InputError as error:
                found, faults = None, error.faults
                assert faults, "a refusal without a reason"
        took = time.process_time() - start
        if faults:
            left = {str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()} - set(files)
            assert left <= set(reader.makes), f"a refusal leaves {sorted(left)}"
    for fault in faults:
        assert "\n" not in fault and len(fault) < 1200, f"no one-line message: {fault[:2000]}"
        assert ";" in fault, f"no remedy: {fault}"
    assert used[0] < MOST, f"took {used[0]:,} bytes of memory"
    strange = next(no_numbers(found), None)
    assert strange is None, f"not a number: {strange}"
    return Outcome(faults, took, used[0])


def no_numbers(value: Any, where: str = "result", depth: int = 0) -> Iterator[str]:
    """Where in a result a number is none."""
    if isinstance(value, float | np.ndarray | np.generic | jax.Array):
        array = np.asarray(value)
        if array.dtype.kind in "fc" and np.isnan(array).any():
            yield where
        return
    if depth > 8 or isinstance(value, str | bytes | type | Path):
        return
    if isinstance(value, Mapping):
        parts = value.items()
    elif isinstance(value, tuple | list):
        parts = enumerate(value)
    elif dataclasses.is_dataclass(value):
        parts = ((f.name, getattr(value, f.name)) for f in dataclasses.fields(value))
    else:
        parts = getattr(value, "__dict__", {}).items()
    for key, part in parts:
        yield from no_numbers(part, f"{where}.{key}", depth + 1)


@contextmanager
def _at_most(seconds: int) -> Iterator[None]:
    """`Hang` after so much processor time, or much more by the clock; code that is not Python's ends it all."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise Hang(f"not read within {seconds} s")

    before = [signal.signal(number, stop) for number in (signal.SIGPROF, signal.SIGALRM)]
    signal.setitimer(signal.ITIMER_PROF, seconds)
    signal.alarm(PATIENCE * seconds)
    faulthandler.dump_traceback_later(2 * PATIENCE * seconds, exit=True, file=sys.__stderr__)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.alarm(0)
        faulthandler.cancel_dump_traceback_later()
        for number, handler in zip((signal.SIGPROF, signal.SIGALRM), before, strict=True):
            signal.signal(number, handler)


@contextmanager
def _memory() -> Iterator[list[int]]:
    """By how many bytes the process grows meanwhile at most; what would take far more gets none."""
    used = [0]
    try:
        _RESET.write_text("5")  # the most so far is what is there now
        before = _read("VmRSS")
    except OSError:
        yield used
        return
    limits = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (_read("VmSize") + 3 * MOST, limits[1]))
    try:
        yield used
    finally:
        resource.setrlimit(resource.RLIMIT_AS, limits)
        used[0] = _read("VmHWM") - before


def _read(key: str) -> int:
    """A number of bytes that the system tells of this process."""
    line = next(line for line in _STATUS.read_text().splitlines() if line.startswith(key))
    return 1024 * int(line.split()[1])

"""One attempt: files that went wrong are read, and are understood or refused; nothing else may happen."""

import signal
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from acf_jax.errors import InputError
from tests.fuzz.readers import Files, Reader

LONGEST = 10  # s; reading the whole files takes a hundredth of it


class Hang(AssertionError):
    """A reader that does not come to an end."""


def attempt(reader: Reader, files: Files, longest: int = LONGEST) -> tuple[list[str], float]:
    """The faults named, none where the files were understood, and the time in seconds."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for relative, content in files.items():
            path = folder / relative
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        start = time.perf_counter()
        try:
            with _at_most(longest):
                reader.read(folder)
            faults = []
        except InputError as error:
            faults = error.faults
            assert faults, "a refusal without a reason"
        took = time.perf_counter() - start
    for fault in faults:
        assert "\n" not in fault and len(fault) < 1200, f"no one-line message: {fault[:2000]}"
        assert ";" in fault, f"no remedy: {fault}"
    return faults, took


@contextmanager
def _at_most(seconds: int) -> Iterator[None]:
    def stop(number: int, frame: FrameType | None) -> None:
        raise Hang(f"not read within {seconds} s")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)

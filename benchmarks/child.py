"""A command in a process of its own: its time, by the clock and of the cores, and its memory at the peak."""

import os
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from typing import NamedTuple


class Spent(NamedTuple):
    """What a command took."""

    seconds: float
    computing: float  # s of all its cores, which other work on the machine lengthens less
    megabytes: float  # largest resident memory
    output: str


def run_python(arguments: Sequence[str], environment: Mapping[str, str]) -> Spent:
    """Run `python ARGUMENTS` with these additions to the environment.

    On Linux a process starts out with the largest memory that its parent had: call this from a small one.

    **Raises:** `CalledProcessError` when it fails; what it printed to stderr has been seen by then.
    """
    command = [sys.executable, *arguments]
    begin = time.perf_counter()
    process = subprocess.Popen(command, env=os.environ | environment, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    output = process.stdout.read()
    # its own usage; getrusage would tell the largest of all children so far
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - begin
    process.returncode = os.waitstatus_to_exitcode(status)
    process.stdout.close()
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
    kilobytes = usage.ru_maxrss / (1024 if sys.platform == "darwin" else 1)
    return Spent(seconds, usage.ru_utime + usage.ru_stime, kilobytes / 1024, output)

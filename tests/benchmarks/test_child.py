"""Processes whose cost is measured: what they print, the memory they take, and that a failure is one."""

import subprocess

import pytest

from benchmarks.child import run_python


def test_a_process_tells_its_own_memory_and_environment():
    code = "import os; room = bytearray(200 << 20); print(os.environ['GREETING'])"
    large = run_python(["-c", code], {"GREETING": "hello"})
    small = run_python(["-c", "pass"], {})
    assert large.output == "hello\n" and large.seconds > 0
    assert 200 < large.megabytes - small.megabytes < 260  # not the largest of all processes so far


def test_a_process_that_fails_is_no_measurement():
    with pytest.raises(subprocess.CalledProcessError):
        run_python(["-c", "raise SystemExit(3)"], {})

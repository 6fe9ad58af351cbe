"""Processes whose cost is measured: what they print, the memory they take, and that a failure is one."""

import subprocess
from pathlib import Path

import pytest

from benchmarks.child import run_python

MEASURE = """
from benchmarks.child import run_python
for code in ("x = b'x' * (200 << 20)", "pass"):
    print(run_python(["-c", code], {}).megabytes)
"""


def test_a_process_tells_what_it_prints_with_its_environment():
    spent = run_python(["-c", "import os; print(os.environ['GREETING'])"], {"GREETING": "hello"})
    assert spent.output == "hello\n" and spent.seconds > 0


def test_memory_is_of_that_process_and_not_of_the_largest_so_far():
    root = str(Path(__file__).parents[2])
    large, small = map(float, run_python(["-c", MEASURE], {"PYTHONPATH": root}).output.split())
    assert 200 < large < 260 and small < 60


def test_a_process_that_fails_is_no_measurement():
    with pytest.raises(subprocess.CalledProcessError):
        run_python(["-c", "raise SystemExit(3)"], {})

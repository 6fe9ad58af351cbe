"""What commands that compute share."""

import os
import platform
import re
import subprocess
import sys

import pytest

THREADS = 12
HEAPS = f"""
import ctypes, threading
from acf_jax.start import start_jax
start_jax()
together = threading.Barrier({THREADS})
def allocate():
    together.wait()
    kept = [bytearray(1000) for _ in range(100)]
    together.wait()
threads = [threading.Thread(target=allocate) for _ in range({THREADS})]
for one in threads: one.start()
for one in threads: one.join()
libc = ctypes.CDLL(None)
libc.fopen.restype = ctypes.c_void_p
ctypes.CDLL(None).malloc_info(0, ctypes.c_void_p(libc.fopen(b"/dev/stdout", b"w")))
libc.fflush(None)
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another C library has other heaps")
@pytest.mark.parametrize(("asked", "heaps"), [(None, 3), ("1", 1)])
def test_threads_share_few_heaps_unless_the_user_says_how_many(asked: str | None, heaps: int) -> None:
    environment = {k: v for k, v in os.environ.items() if k != "MALLOC_ARENA_MAX"}
    environment |= {"MALLOC_ARENA_MAX": asked} if asked else {}
    told = subprocess.run(
        [sys.executable, "-c", HEAPS], env=environment, capture_output=True, text=True, check=True
    ).stdout
    assert len(re.findall(r"<heap nr=", told)) == heaps

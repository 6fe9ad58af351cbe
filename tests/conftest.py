"""Settings every test runs under: float64, no silent rank promotion, warnings as errors.

Compiled code is kept where the commands keep it: the tests share it with one another and with the commands they start.
It is not optimised: the tests compile more than they compute.
"""

import os
import signal
from importlib.metadata import version
from pathlib import Path

if (
    f"jaxlib=={version('jaxlib')}"
    in (Path(__file__).parents[1] / "constraints.txt").read_text("utf-8").split()
):
    # Halves the time to compile. Others may not know it, and abort.
    os.environ.setdefault(
        "XLA_FLAGS", "--xla_backend_optimization_level=0 --xla_cpu_use_fusion_emitters=false"
    )
os.environ.setdefault("XLA_FLAGS", "--xla_backend_optimization_level=0")

import jax

from acf_jax.start import start_jax

start_jax()
jax.config.update("jax_numpy_rank_promotion", "raise")

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # A shell starts what runs in its background so, and every process of these tests would inherit it.
    signal.signal(signal.SIGINT, signal.default_int_handler)

"""What commands that compute share: double precision, no detour by a thread, compiled code kept between calls."""

import os
from pathlib import Path

import jax


def start_jax() -> None:
    """Switch JAX to float64, to small computations in the calling thread, and to a cache of compiled code.

    To be called before the first computation.
    """
    jax.config.update("jax_enable_x64", True)
    # handing over to a thread costs more than a peak
    jax.config.update("jax_cpu_enable_async_dispatch", False)
    try:
        cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "acf-jax" / "compiled"
        cache.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):
        return  # a home that is read-only, or that a container's user lacks, costs compile time, nothing else
    jax.config.update("jax_compilation_cache_dir", str(cache))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)

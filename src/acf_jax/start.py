"""What commands that compute share: double precision, no detour by a thread, compiled code kept between calls."""

import ctypes
import os
import platform
from pathlib import Path

import jax

from acf_jax.errors import InputError, shown

PLATFORMS = ("JAX_PLATFORMS", "JAX_PLATFORM_NAME")  # variables that choose JAX's devices
M_ARENA_MAX = -8  # of glibc's malloc.h
ARENAS = 3  # of the main thread, and of the two of a diagnosis


def start_jax() -> None:
    """Switch JAX to float64, to small computations in the calling thread, and to a cache of compiled code.

    What threads have freed is shared among few heaps.

    To be called before the first computation.

    **Raises:** `InputError` where JAX has none of the devices that the environment asks for.
    """
    jax.config.update("jax_enable_x64", True)
    # handing over to a thread costs more than a peak
    jax.config.update("jax_cpu_enable_async_dispatch", False)
    _share_heaps()
    check_devices()
    if jax.config.jax_compilation_cache_dir is not None:  # type: ignore[attr-defined]
        return  # the user has a cache already
    try:
        cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "acf-jax" / "compiled"
        cache.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):
        return  # a home that is read-only, or that a container's user lacks, costs compile time, nothing else
    jax.config.update("jax_compilation_cache_dir", str(cache))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)


def _share_heaps() -> None:
    """By default glibc has eight heaps a core, and keeps in each what was freed there: more than what is in use."""
    if platform.libc_ver()[0] == "glibc" and "MALLOC_ARENA_MAX" not in os.environ:
        ctypes.CDLL(None).mallopt(M_ARENA_MAX, ARENAS)


def check_devices() -> None:
    """`InputError` where JAX has none of the devices that the environment asks for."""
    try:
        jax.devices()
    except Exception as error:  # an AssertionError among them, for a plugin that is not installed
        asked = [f"{name}={shown(os.environ[name])}" for name in PLATFORMS if os.environ.get(name)]
        what = f"{' and '.join(asked)}: JAX has no such device here"
        remedy = "unset the variable, set it to cpu, or install JAX for that device"
        if not asked:
            what, remedy = "JAX finds no device", f"set {PLATFORMS[0]}=cpu, or mend its installation"
        reason = str(error).partition("\n")[0]
        raise InputError(f"{what}{f' ({reason})' if reason else ''}; {remedy}") from None

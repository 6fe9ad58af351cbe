"""What the figures were measured on."""

import os
import platform
from importlib.metadata import version
from pathlib import Path


def cores() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def describe() -> str:
    """Processor, cores, and the versions that matter."""
    info = Path("/proc/cpuinfo")
    names = [line.split(":", 1)[1].strip() for line in info.read_text().splitlines() if "model name" in line]
    processor = names[0] if names else platform.processor()
    wide = " (AVX-512)" if "avx512f" in info.read_text() else ""
    packages = ", ".join(f"{name} {version(name)}" for name in ("jax", "numba", "scipy", "optimistix"))
    return f"{processor}{wide}, {cores()} cores, Python {platform.python_version()}, {packages}"


def load() -> str:
    """How busy the machine was in the last minute, what was measured included."""
    return f"load {os.getloadavg()[0]:.1f}"

"""What a run depends on besides its configuration."""

import platform

import equinox as eqx
import jax
import numpy as np
import optax

import acf_jax


def versions() -> dict[str, str]:
    """Python's version and those of the packages that decide the figures."""
    packages = {"acf-jax": acf_jax, "jax": jax, "equinox": eqx, "optax": optax, "numpy": np}
    return {"python": platform.python_version()} | {name: p.__version__ for name, p in packages.items()}

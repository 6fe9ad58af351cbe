"""A trimmed library: compiled programs are what a diagnosis costs in a test."""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module

import pytest

from acf_jax import effects
from acf_jax.inference.free_curves import free_curves


@contextmanager
def few_explanations(kept: tuple[str, ...], curves: tuple[str, ...]) -> Iterator[None]:
    """Within the block a diagnosis knows these effects and free curves only."""
    library = {name: cls for name, cls in effects.library().items() if name in kept}
    kept_curves = {name: cls for name, cls in free_curves().items() if name in curves}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(effects, "library", lambda: library)
        patch.setattr(import_module("acf_jax.diagnosis.diagnose"), "free_curves", lambda: kept_curves)
        yield

"""A trimmed library: compiled programs are what a diagnosis costs in a test."""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module

import pytest

from acf_jax.diagnosis import candidates, identifiability
from acf_jax.effects import library


@contextmanager
def few_explanations(effects: tuple[str, ...], curves: tuple[str, ...]) -> Iterator[None]:
    """Within the block a diagnosis knows these effects and free curves only."""
    kept = {name: cls for name, cls in library().items() if name in effects}
    kept_curves = {name: cls for name, cls in candidates.free_curves().items() if name in curves}
    with pytest.MonkeyPatch.context() as patch:
        for module in (import_module("acf_jax.diagnosis.diagnose"), identifiability):
            patch.setattr(module, "library", lambda: kept)
        patch.setattr(candidates, "free_curves", lambda: kept_curves)
        yield

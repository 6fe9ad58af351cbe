"""A trimmed library: compiled programs are what a diagnosis costs in a test."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from acf_jax.diagnosis import candidates, separate
from acf_jax.diagnosis import diagnose as diagnose_module
from acf_jax.effects import library


@contextmanager
def few_explanations(effects: tuple[str, ...], ports: tuple[str, ...]) -> Iterator[None]:
    """Within the block a diagnosis knows these effects and ports only."""
    kept = {name: cls for name, cls in library().items() if name in effects}
    open_ports = {name: cls for name, cls in candidates.ports().items() if name in ports}
    with pytest.MonkeyPatch.context() as patch:
        for module in (diagnose_module, separate):
            patch.setattr(module, "library", lambda: kept)
        patch.setattr(candidates, "ports", lambda: open_ports)
        yield

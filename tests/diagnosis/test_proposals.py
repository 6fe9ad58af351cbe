"""Proposals of the search: what is dropped is fitted with the compiled code that is there."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from acf_jax.diagnosis import proposals
from acf_jax.inference.fit import Fit
from acf_jax.inference.forward import Grid


@pytest.mark.parametrize("program", [None, ("end_stop", "gravity", "sensor_lag")])
def test_a_law_is_dropped_within_the_program_that_has_it(
    monkeypatch: pytest.MonkeyPatch, program: Any
) -> None:
    seen: list[tuple[Any, ...]] = []
    monkeypatch.setattr(
        proposals, "fit", lambda o, explanation, theta, *rest, **how: seen.append((explanation, theta, how))
    )
    both = ("end_stop", "gravity")
    physical = np.array([1.0, 2.0, 3.0, 4.0, 0.1, 0.2, 9.0])  # rig, end stop, gravity
    fitted: Any = SimpleNamespace(
        explanation=both,
        physical=physical,
        theta=np.append(physical, [0.5, 0.6]),
        nuisance=None,
        program=Fit.program.fget(SimpleNamespace(explanation=both, grid=Grid(1e-4, 100, program=program))),  # type: ignore[attr-defined]
    )
    proposals.without(None, fitted, "end_stop", 0)  # type: ignore[arg-type]
    ((explanation, theta, how),) = seen
    assert explanation == ("gravity",) and how["program"] == (program or both)
    assert theta.tolist() == [1.0, 2.0, 3.0, 4.0, 9.0, 0.5, 0.6]

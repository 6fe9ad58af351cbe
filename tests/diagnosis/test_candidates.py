"""From where ports are fitted, with fits that are made up."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from acf_jax.diagnosis import candidates
from acf_jax.diagnosis.space import starts


@pytest.fixture
def begun(monkeypatch: pytest.MonkeyPatch) -> list[tuple[float, int]]:
    """The last parameter of each port's start that was fitted, and for how many iterations; 300 fits best, with 10."""
    seen: list[tuple[float, int]] = []

    def fit(_: Any, explanation: Any, start: np.ndarray, *rest: Any, iterations: int, **more: Any) -> Any:
        seen.append((float(start[-2]), iterations))
        return SimpleNamespace(explanation=explanation, objective=abs(start[-2] - 300.0) + 10.0)

    monkeypatch.setattr(candidates, "fit", fit)
    monkeypatch.setattr(candidates, "go_on", lambda _, glance: glance)
    return seen


GROUND: Any = SimpleNamespace(
    observations=SimpleNamespace(prior=SimpleNamespace(values=np.ones(4))),
    fitted=SimpleNamespace(theta=np.ones(5), own=None),
)


def port(name: str, objective: float) -> Any:
    return SimpleNamespace(explanation=(name,), objective=objective)


def test_a_port_gets_a_glance_from_each_of_its_starts(begun: list[tuple[float, int]]) -> None:
    found = candidates.fit_further(GROUND, port("unknown_robot", 1000.0))
    assert found.objective == 10.0
    assert begun == [(start[-1], candidates.GLANCE) for start in starts("unknown_robot")] * 2


def test_a_better_fit_of_a_port_stands(begun: list[tuple[float, int]]) -> None:
    known = port("unknown_robot", 5.0)
    assert candidates.fit_further(GROUND, known) is known


def test_a_port_with_one_start_is_not_fitted_again(begun: list[tuple[float, int]]) -> None:
    known = port("unknown_contact", 1000.0)
    assert candidates.fit_further(GROUND, known) is known and not begun

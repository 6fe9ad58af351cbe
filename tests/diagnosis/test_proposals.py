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
        common=np.array([0.5, 0.6]),
        nuisance=None,
        program=Fit.program.fget(SimpleNamespace(explanation=both, grid=Grid(1e-4, 100, program=program))),  # type: ignore[attr-defined]
    )
    proposals.without(None, fitted, ("gravity",))  # type: ignore[arg-type]
    ((explanation, theta, how),) = seen
    assert explanation == ("gravity",) and how["program"] == (program or both)
    assert theta.tolist() == [1.0, 2.0, 3.0, 4.0, 9.0, 0.5, 0.6]


def test_another_law_is_put_in_place_of_each(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where in place of another one two promise more."""

    def without(o: Any, leader: Any, rest: Any) -> Any:
        return SimpleNamespace(explanation=rest, objective=40.0)

    def couples(rest: Any, effects: Any) -> list[proposals.Couple]:
        gains = {
            "gravity": {"end_stop": 70.0, "sensor_lag": 30.0, "sensor_scale": 60.0},
            "end_stop": {"pad_mass": 5.0},
        }
        (kept,) = rest.explanation
        return [
            proposals.Couple(rest, name, [], gain, rest.objective - gain / 2)
            for name, gain in gains[kept].items()
        ]

    asked: list[Any] = []
    monkeypatch.setattr(proposals, "without", without)
    monkeypatch.setattr(proposals, "couples", couples)
    monkeypatch.setattr(proposals, "fit_couples", lambda o, wanted, *rest, **how: asked.extend(wanted) or [])
    fitted = SimpleNamespace(explanation=("end_stop", "gravity"))
    ground: Any = SimpleNamespace(observations=None, fitted=fitted, beside=lambda rest: rest)
    proposals.swap(proposals.Leader.of(ground), [], [("end_stop", "gravity")])
    assert [(couple.explanation, couple.objective) for couple in asked] == [
        (("gravity", "sensor_scale"), 10.0),
        (("end_stop", "pad_mass"), 37.5),
    ]

"""Which pairs are tried, with fits that are made up: what counts is only how well each explanation fits."""

from collections.abc import Sequence
from itertools import combinations
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from acf_jax.diagnosis import candidates, proposals, search
from acf_jax.diagnosis.proposals import Couple
from acf_jax.diagnosis.search import fit_alone, fit_together
from acf_jax.inference.free_curves import free_curves
from acf_jax.inference.parameters import Explanation

EFFECTS = ("coulomb_friction", "gravity", "pad_relaxation", "robot_compliance", "sensor_lag")
SAMPLES = 1000


def _fit(explanation: Explanation, chi_square: float, mass: float = 0.0) -> Any:
    """A fit whose rig has its mass so many standard deviations off its prior."""
    return SimpleNamespace(
        explanation=explanation, objective=chi_square / 2, u=np.array([mass, 0.0, 0.0, 0.0, 0.0])
    )


@pytest.fixture
def fitted(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Runs a search over made-up chi-squares, of pairs 1,000 where not given; returns what was fitted."""

    def run(
        chi_squares: dict[Explanation, float], promises: dict[Explanation, float], mass: float = 0.0
    ) -> list[Explanation]:
        def couples(leader: Any, effects: Sequence[str]) -> list[Couple]:
            ground: Any = SimpleNamespace(fitted=leader, instead_of=None)
            pairs = [
                Couple(ground, e, [np.zeros(1)], 0.0, 0.0) for e in effects if e not in leader.explanation
            ]
            return [
                c._replace(gain=g, objective=-g) for c in pairs for g in [promises.get(c.explanation, 0.0)]
            ]

        def more(ground: Any, name: str, *rest: Any) -> Any:
            explanation = tuple(sorted((*ground.fitted.explanation, name)))
            return _fit(explanation, chi_squares.get(explanation, 1000.0))

        monkeypatch.setattr(search, "couples", couples)
        monkeypatch.setattr(search, "PAIRS", 6)  # fewer than are tried of five effects
        monkeypatch.setattr(search.Ground, "of", lambda _, leader: leader)
        monkeypatch.setattr(
            candidates, "glances", lambda _, name: [_fit((name,), chi_squares.get((name,), 1100.0), mass)]
        )
        monkeypatch.setattr(proposals, "fit_more", more)
        monkeypatch.setattr(candidates, "fit_further", lambda _, fitted: fitted)
        monkeypatch.setattr(candidates, "go_on", lambda _, glance: ended.append(glance.explanation) or glance)
        observations: Any = SimpleNamespace(n_used=SAMPLES)
        recalibrated = _fit((), 1200.0)
        alone = fit_alone(observations, recalibrated, [*EFFECTS, *free_curves()])
        fits = fit_together(observations, recalibrated, alone)
        return [f.explanation for f in fits]

    ended: list[Explanation] = []
    run.ended = ended  # type: ignore[attr-defined]
    return run


TRUE = ("gravity", "pad_relaxation")
SINGLES = {("coulomb_friction",): 1010.0, ("gravity",): 1012.0, ("pad_relaxation",): 1080.0}
PROMISES = {("coulomb_friction", "sensor_lag"): 20.0}


def test_few_pairs_are_tried_where_effects_explain_as_much_as_the_free_curves(fitted: Any) -> None:
    found = fitted({**SINGLES, ("unknown_robot",): 1000.0, TRUE: 900.0}, PROMISES)
    assert [e for e in found if len(e) == 2] == [("coulomb_friction", "sensor_lag")]


def test_what_a_free_curve_explains_beyond_every_effect_is_searched_for_among_pairs(fitted: Any) -> None:
    """The best effect stands in for one much like it: the true pair is found by a swap."""
    stands_in = ("coulomb_friction", "pad_relaxation")
    found = fitted({**SINGLES, ("unknown_robot",): 910.0, stands_in: 905.0, TRUE: 900.0}, PROMISES)
    assert TRUE in found and stands_in in found
    assert len([e for e in found if len(e) == 2]) == search.PAIRS


def test_pairs_are_tried_widely_where_the_rig_of_the_best_effect_hides_something(fitted: Any) -> None:
    """A compliant robot behaves much like a heavier flange: the recalibrated mass takes it up."""
    chi_squares = {**SINGLES, ("unknown_robot",): 1000.0, TRUE: 900.0}
    assert TRUE not in fitted(chi_squares, PROMISES, mass=3.0)
    assert TRUE in fitted(chi_squares, PROMISES, mass=5.0)


def test_pairs_are_tried_widely_where_no_effect_explains_the_data(fitted: Any) -> None:
    found = fitted({(name,): 1300.0 for name in (*EFFECTS, *free_curves())}, {})
    assert len([e for e in found if len(e) == 2]) == search.PAIRS


def test_a_pair_far_behind_the_best_gets_no_more_than_a_glance(fitted: Any) -> None:
    second = ("coulomb_friction", "gravity")
    pairs: dict[Explanation, float] = dict.fromkeys(combinations(EFFECTS, 2), 5000.0)
    found = fitted(
        {(name,): 6000.0 for name in (*EFFECTS, *free_curves())} | pairs | {TRUE: 1000.0, second: 3000.0}, {}
    )
    assert len([e for e in found if len(e) == 2]) == search.PAIRS
    assert [e for e in fitted.ended if len(e) == 2] == [TRUE, second]


def test_every_single_effect_leads_to_pairs_where_the_best_ones_leave_much(
    fitted: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The weakest effect alone is where the fit of the true pair has to begin."""
    monkeypatch.setattr(search, "BEGINNINGS", 1)
    true = ("robot_compliance", "sensor_lag")
    singles = {(name,): 6000.0 + 100 * k for k, name in enumerate((*EFFECTS, *free_curves()))}
    pairs = dict.fromkeys(combinations(EFFECTS, 2), 1400.0)
    assert true not in fitted({**singles, **pairs, true: 1000.0}, {true: 20.0})  # near enough already
    pairs = dict.fromkeys(pairs, 5000.0)
    assert true in fitted({**singles, **pairs, true: 1000.0}, {true: 20.0})

"""From what fits leave to probabilities."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from acf_jax.dataset import Noise
from acf_jax.evidence.posterior import (
    HIGHEST,
    Scored,
    credible_set,
    doubt,
    explanations,
    of_each_fit,
    probabilities,
)
from acf_jax.evidence.scores import WEIGHTS, Evidence, Weights, log_scores
from acf_jax.inference.fit import Fit
from acf_jax.inference.free_curves import free_curves
from acf_jax.inference.parameters import Explanation, component_of


def _probabilities(chi_square: tuple[float, ...]) -> np.ndarray:
    names = [(), ("gravity",), ("coulomb_friction",), ("unknown_actuator",)]
    rest = (0.0,) * 4
    return probabilities([Evidence(e, x, rest) for e, x in zip(names, chi_square, strict=True)], 1000)


def test_probabilities_follow_the_evidence_and_are_never_certain() -> None:
    same = _probabilities((1000.0, 1000.0, 1000.0, 1000.0))
    assert same.argmax() == 0 and same.sum() == pytest.approx(1.0)
    clear = _probabilities((10000.0, 1000.0, 1400.0, 998.0))
    assert clear.argmax() == 1
    assert clear.max() <= HIGHEST + 1e-12
    outside = _probabilities((100000.0, 40000.0, 60000.0, 1000.0))
    assert outside.argmax() == 3


def test_beside_a_form_that_leaves_only_noise_even_a_large_gap_hides_no_difference() -> None:
    def odds(*left: float) -> float:
        one, other = _probabilities((1e6, *left, 1e6))[1:3]
        return float(one / other)

    assert odds(1000.0, 1010.0) / odds(1000.0, 1000.0) == pytest.approx(np.exp(0.5 * WEIGHTS.exact * 10.0))
    assert odds(3000.0, 3010.0) / odds(3000.0, 3000.0) < 1.1  # neither form is exact


def test_a_pair_that_leaves_only_noise_stands_before_a_law_that_leaves_much_more() -> None:
    """However small a share that is of the gap."""
    names: list[Explanation] = [(), ("gravity",), ("pad_mass", "sensor_lag")]

    def odds(left: float) -> float:
        chi_square = (5e6, left, 1000.0)
        p = probabilities([Evidence(e, x, (0.0,) * 4) for e, x in zip(names, chi_square, strict=True)], 1000)
        return float(p[2] / p[1])

    assert odds(1000.0) < 0.1
    assert odds(32000.0) > 10.0


def test_a_form_that_strains_the_rig_is_not_exact() -> None:
    """As in a blind run: a pair that fits far within the noise only because the mass is 15 deviations off."""
    names: list[Explanation] = [(), ("gravity", "sensor_lag"), ("pad_mass", "sensor_lag")]

    def odds(strain: float) -> float:
        rows = zip(names, (80000.0, 1000.0, 760.0), ((0.0,), (0.0,), (strain,)), strict=True)
        p = probabilities([Evidence(*row) for row in rows], 1000)
        return float(p[1] / p[2])

    assert odds(240.0) > 10.0
    assert odds(0.0) < 0.1


def port_shares(strain: float = 0.0, weights: Weights = WEIGHTS, **chi_square: float) -> dict[str, float]:
    """Of an unknown cause, by what each free curve leaves; its rig strained at the actuator's."""
    names = [(), *((name,) for name in free_curves())]
    left = (20000.0, *(chi_square[component_of(name)] for name in free_curves()))
    strains = [(strain if "unknown_actuator" in name else 0.0,) * 4 for name in names]
    p = probabilities([Evidence(*row) for row in zip(names, left, strains, strict=True)], 1000, weights)[1:]
    return {component_of(name): float(value) for name, value in zip(free_curves(), p / p.sum(), strict=True)}


def test_the_component_stays_open_where_none_fits() -> None:
    alike = replace(WEIGHTS, in_series=0.0)
    near = port_shares(weights=alike, actuator=1000.0, contact=2000.0, robot=2000.0, sensor=2000.0)
    far = port_shares(weights=alike, actuator=11000.0, contact=12000.0, robot=12000.0, sensor=12000.0)
    assert near["actuator"] > 0.9
    assert far["actuator"] < 0.8


def test_free_curves_that_all_forces_pass_and_strained_ones_have_to_fit_better() -> None:
    even = port_shares(actuator=1000.0, contact=1000.0, robot=1000.0, sensor=1000.0)
    assert even["actuator"] == even["contact"]
    assert even["robot"] == even["sensor"] == pytest.approx(even["contact"] * np.exp(-WEIGHTS.in_series))
    strained = port_shares(20.0, actuator=1000.0, contact=1000.0, robot=1000.0, sensor=1000.0)
    assert strained["actuator"] < 0.1 * strained["contact"]


def test_noise_whose_colour_is_hardly_known_is_no_unknown_cause() -> None:
    evidence = [Evidence(e, 1350.0, (0.0,) * 4) for e in ((), ("unknown_robot",))]
    known, guessed = (probabilities(evidence, 1000, noise_doubt=doubt)[0] for doubt in (0.0, 0.2))
    assert guessed > 0.99 and known < 0.01
    assert Noise(1.0, 0.9, 1e-3, samples=200).doubt == pytest.approx(0.2)
    assert Noise(1.0, samples=20).doubt == 0.0


def test_free_curves_and_further_effects_cost_more_where_single_effects_pay_for_their_freedom() -> None:
    names: list[Explanation] = [(), ("gravity",), ("gravity", "sensor_lag"), ("unknown_robot",)]

    def odds(volume: float | None) -> np.ndarray:
        rows = zip(names, (1050.0, 1010.0, 1005.0, 1000.0), strict=True)
        evidence = [Evidence(e, x, (0.0,) * 4, volume if e == ("gravity",) else None) for e, x in rows]
        p = np.exp(log_scores(evidence, 1000))
        return np.asarray(p[2:4] / p[0])

    np.testing.assert_allclose(odds(-3.0) / odds(None), np.exp(-WEIGHTS.small))


def test_what_a_fit_owes_to_what_it_has_seen_counts_but_where_freedom_has_its_price() -> None:
    names: list[Explanation] = [(), ("gravity",), ("gravity", "sensor_lag"), ("unknown_robot",)]

    def odds(owed: float, volume: float | None = None) -> float:
        rows = zip(names, (1100.0, 1040.0, 1012.0, 1000.0), (0.0, 0.0, 10.0, 10.0 + owed), strict=True)
        evidence = [
            Evidence(e, x, (0.0,) * 4, volume if e == ("gravity",) else None, more) for e, x, more in rows
        ]
        score = log_scores(evidence, 1000)
        return float(np.exp(score[2] - score[3]))

    assert odds(0.0) < 0.5 and odds(30.0) > 20.0
    assert odds(30.0, volume=-3.0) == odds(0.0, volume=-3.0)


def test_beside_a_free_curve_that_leaves_only_noise_a_law_is_not_excused_by_a_large_gap() -> None:
    """A tenth of the half chi-square counts at least, however small a share of the gap it is."""

    def odds(left: float) -> float:
        evidence = [
            Evidence(e, x, (0.0,) * 4)
            for e, x in (((), 1e6), (("gravity",), left), (("unknown_robot",), 1000.0))
        ]
        score = log_scores(evidence, 1000)
        return float(score[1] - score[2])

    assert odds(1000.0) - odds(1400.0) == pytest.approx(0.5 * WEIGHTS.exact_of_all * 400.0)


def test_an_effect_that_fits_any_noise_must_fit_better() -> None:
    plain, eager = ("sensor_lag",), ("sensor_resonance",)
    rest = (0.0,) * 4
    even = [Evidence(e, x, rest) for e, x in (((), 5000.0), (plain, 1000.0), (eager, 1000.0))]
    p = probabilities(even, 1000)
    assert p[2] / p[1] == pytest.approx(np.exp(-WEIGHTS.noise))


def test_the_credible_set_is_the_smallest_that_holds_95_percent() -> None:
    scored = [Scored(("a",), 0.6), Scored(("b",), 0.36), Scored((), 0.04)]
    assert credible_set(scored) == [("a",), ("b",)]


def test_fits_are_as_probable_as_their_explanations_are_said_to_be() -> None:
    names = [(), ("gravity",), ("unknown_actuator",), ("unknown_robot",)]
    fits = cast(list[Fit], [SimpleNamespace(explanation=name) for name in names])
    before = np.array([0.0, 0.98, 0.015, 0.005])
    stated = doubt(explanations(fits, before), 0.1)
    p = of_each_fit(fits, before, stated)
    assert dict(zip(names, p, strict=True))[("gravity",)] == pytest.approx(0.245)
    assert p[2:] == pytest.approx([0.755 * 0.75, 0.755 * 0.25])


def test_no_explanation_is_certain_nor_are_the_free_curves_together() -> None:
    fits = [cast(Fit, SimpleNamespace(explanation=e)) for e in [(), *((name,) for name in free_curves())]]
    scored = explanations(fits, np.array([0.0004, 0.9, 0.0496, 0.03, 0.02]))
    assert [s.explanation for s in scored] == [("unknown",), ()]
    assert scored[0].probability == pytest.approx(HIGHEST)
    assert sum(s.probability for s in scored) == pytest.approx(1.0)
    doubted = doubt([Scored(("gravity",), 0.99), Scored((), 0.01)], 0.0)
    assert doubted[0].explanation == ("unknown",) and doubted[0].probability < 0.995

"""Laws in any number: what proposals add, drop and swap."""

from dataclasses import replace
from importlib import import_module
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from acf_jax.diagnosis.candidates import fit_nominal
from acf_jax.diagnosis.diagnose import _corrected
from acf_jax.diagnosis.explain import _Weighed, explain
from acf_jax.diagnosis.proposals import add, couples, fit_couples, proposed, swap
from acf_jax.evidence.marginal import Marginal
from acf_jax.evidence.posterior import UNKNOWN, posterior
from acf_jax.inference.baseline import Ground
from acf_jax.inference.discrepancy import FORMS, SIZES
from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import Explanation, begin, starts
from tests.few import few_explanations
from tests.imagined import RIG, imagined

explain_module = import_module("acf_jax.diagnosis.explain")
LAWS = ("gravity", "sensor_scale")
KEPT = ("gravity", "pad_relaxation", "sensor_scale")


@pytest.fixture(scope="module")
def two() -> Observations:
    """Trials of a rig with two laws, in noise."""
    o = imagined(LAWS, (12.0, 0.04))
    noise = o.noise.std * np.random.default_rng(2).standard_normal(o.force.shape)
    return replace(o, force=np.where(o.used, o.force + noise, 0.0))


@pytest.fixture(scope="module")
def alone(two: Observations) -> list[Fit]:
    """The recalibrated model, and each of three laws alone."""
    singles = {"gravity": [6.0], "sensor_scale": [0.02], "pad_relaxation": [0.2, 0.2, 5e-3]}
    return [fit_nominal(two), *(fit(two, (name,), begin(RIG.values, x)) for name, x in singles.items())]


@pytest.mark.long
def test_what_laws_alone_leave_is_found_by_adding_one(two: Observations, alone: list[Fit]) -> None:
    with few_explanations(KEPT, ()):
        fits, evidence = explain(two, alone, KEPT)
    assert [f.explanation for f in fits[:4]] == [f.explanation for f in alone]
    scored = posterior(evidence).scored
    assert scored[0].explanation == LAWS and scored[0].probability > 0.9
    best = next(f for f in fits if f.explanation == LAWS)
    assert best.physical[-2:] == pytest.approx([12.0, 0.04], rel=0.2)

    def sizes(explanation: Explanation) -> set[float]:
        return {m.discrepancy for m in evidence if m.explanation == explanation}

    assert sizes(LAWS) == {0.0, *(size for size in SIZES if size <= FORMS)}
    assert sizes(()) == {0.0, FORMS}  # beside smaller ones it is hopeless


def test_what_is_missed_by_more_than_forms_are_wrong_is_unknown(
    two: Observations, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The force of a motor at 700 Hz, in another phase at each condition, which no law has."""
    phase = 2 * np.pi * 700 * two.time + 2.0 * two.condition[:, None]
    o = replace(two, force=np.where(two.used, two.force * (1 + 0.3 * np.sin(phase)), 0.0))
    monkeypatch.setattr(explain_module, "proposed", lambda *given: [])
    fits = [fit_nominal(o), fit(o, ("gravity",), begin(RIG.values, [6.0]))]
    fits.append(fit(o, ("unknown_contact",), begin(RIG.values, starts("unknown_contact", o.measures)[0])))
    _, evidence = explain(o, fits, KEPT)
    best = max(evidence, key=lambda m: m.log_z)
    assert best.discrepancy > FORMS
    scored = posterior(evidence).scored
    assert scored[0].explanation == UNKNOWN and scored[0].probability > 0.5


def test_the_search_goes_from_wide_discrepancies_to_narrow_ones(
    two: Observations, alone: list[Fit], monkeypatch: pytest.MonkeyPatch
) -> None:
    """And from each to the next narrower one with what was found; exact forms are only weighed."""
    sizes: list[float] = []

    def propose(ground: Ground, effects: object, known: dict[Explanation, float]) -> list[Fit]:
        waves = ground.observations.discrepancy
        sizes.append(float(np.abs(waves.own).max()) if waves else 0.0)
        if len(sizes) > 1:
            assert LAWS in known  # found beside the widest
            return []
        return [fit(ground.observations, LAWS, begin(RIG.values, [12.0], [0.04]), warm=True)]

    monkeypatch.setattr(explain_module, "proposed", propose)
    fits, evidence = explain(two, alone, KEPT)
    narrowing = sizes[: len(set(sizes))]
    assert narrowing == sorted(narrowing, reverse=True) and len(narrowing) > 2
    assert 0.0 not in sizes
    assert LAWS in {f.explanation for f in fits}
    exact = {m.explanation for m in evidence if not m.discrepancy}
    assert {LAWS, *((law,) for law in LAWS)} <= exact  # what it found, and that without each of its laws


def test_what_breaks_down_without_a_discrepancy_has_no_model_and_is_left_out() -> None:
    rows = [Marginal((), 0.0, 9.0, 0.0), Marginal(("gravity",), 0.3, 1.0, 0.0)]
    weighed = SimpleNamespace(
        plain={(): None}, marginals=rows, _considerable=lambda share: [], _take_apart=list
    )
    assert [m.explanation for m in _Weighed.with_changes(cast(_Weighed, weighed))] == [()]


def _leaders(log_z: dict[Explanation, float]) -> list[Explanation]:
    marginals = [Marginal(e, min(SIZES), -z, 0.0) for e, z in log_z.items()]
    marginals.append(Marginal(("end_stop",), 0.0, 0.0, 0.0))  # with exact forms, which are not searched
    weighed = SimpleNamespace(plain=log_z, marginals=marginals)
    return [m.explanation for m in _Weighed.leaders(cast(_Weighed, weighed))]


def test_laws_are_added_to_though_a_free_curve_is_far_ahead() -> None:
    curve = ("unknown_robot",)
    ahead: dict[Explanation, float] = {
        (): -5000.0,
        ("gravity",): -900.0,
        ("sensor_lag",): -4000.0,
        curve: -400.0,
    }
    assert _leaders(ahead) == [("gravity",), curve]
    assert _leaders(ahead | {curve: -4000.0}) == [("gravity",)]


def test_laws_that_explain_as_well_as_others_are_added_to_as_well() -> None:
    """But not those of the leader with one more, which is added anyway."""
    pair, other = ("gravity", "sensor_lag"), ("coulomb_friction", "sensor_lag")
    near: dict[Explanation, float] = {
        (): -5000.0,
        pair: -400.0,
        (*pair, "sensor_scale"): -402.0,
        other: -404.0,
    }
    assert _leaders(near) == [pair, other]
    assert _leaders(near | {other: -900.0}) == [pair]


def test_each_proposal_changes_one_law(two: Observations, alone: list[Fit]) -> None:
    _, gravity, scale, _ = alone
    (pair,) = fit_couples(add(Ground.of(two, gravity), KEPT, {}), near=True)
    assert pair.explanation == LAWS and pair.objective < min(gravity.objective, scale.objective)
    found = {f.explanation: f for f in proposed(Ground.of(two, pair), KEPT, {LAWS: 0.0})}
    dropped, swapped = (
        {("gravity",), ("sensor_scale",)},
        {("gravity", "pad_relaxation"), ("pad_relaxation", "sensor_scale")},
    )
    assert found.keys() == {*dropped, *swapped, KEPT}
    assert found["sensor_scale",].objective <= scale.objective + 0.1
    assert swap(Ground.of(two, gravity), KEPT, {}) == []  # every law is fitted alone


def test_the_law_that_promises_most_is_added_be_it_little(two: Observations, alone: list[Fit]) -> None:
    (pair,) = fit_couples(add(Ground.of(two, alone[1]), KEPT, {}), near=True)
    (triple,) = fit_couples(add(Ground.of(two, pair), KEPT, {}), near=True)
    assert triple.explanation == KEPT and pair.objective - 3 < triple.objective <= pair.objective + 0.1
    (other,) = add(Ground.of(two, alone[1]), KEPT, {LAWS: 0.0})
    assert other.explanation == ("gravity", "pad_relaxation")


def test_explanations_of_three_laws_share_the_program_that_has_all_of_them(
    two: Observations, alone: list[Fit]
) -> None:
    """Pairs have their own, which other data sets use again."""
    (pair,) = fit_couples(add(Ground.of(two, alone[1]), KEPT, {}), near=True)
    assert pair.program == LAWS
    ground = Ground.of(two, pair)
    of_three = [c for c in couples(ground, [*KEPT, "sensor_lag"])]
    assert {f.program for f in fit_couples(of_three, near=True)} == {tuple(sorted((*KEPT, "sensor_lag")))}


def test_where_all_laws_are_hopeless_none_leads() -> None:
    """Beside a size that only free curves were brought to."""
    weighed = SimpleNamespace(
        marginals=[Marginal(("unknown_robot",), 0.01, 0.0, 0.0), Marginal((), 0.0, 0.0, 0.0)]
    )
    assert _Weighed.best_laws(cast(_Weighed, weighed), 0.01) == []
    assert _Weighed.best_laws(cast(_Weighed, weighed), 0.0) == [weighed.marginals[1]]
    assert not _Weighed.is_wider_better(cast(_Weighed, weighed), 0.0)


def test_where_every_free_curve_breaks_down_the_recalibrated_model_stands_for_an_unknown_cause(
    alone: list[Fit],
) -> None:
    """No law, and all of it missed by a tenth of the force."""
    rows = [Marginal((), 0.1, 1.0, 0.0), *(Marginal(f.explanation, 0.0, 900.0, 0.0) for f in alone)]
    told = posterior(rows)
    assert told.scored[0].explanation == UNKNOWN
    assert _corrected(alone, np.array([told.of(f.explanation) for f in alone]), told) is alone[0]

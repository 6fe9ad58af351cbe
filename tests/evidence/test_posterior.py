"""From marginal likelihoods to probabilities."""

import math
from itertools import combinations

import numpy as np
import pytest
from scipy.special import logsumexp

from acf_jax.effects import COMPONENTS, library
from acf_jax.evidence.learnt import ELSEWHERE, read_calibration
from acf_jax.evidence.marginal import Marginal
from acf_jax.evidence.posterior import (
    UNKNOWN,
    Scored,
    credible_set,
    log_posterior,
    log_prior,
    minor,
    posterior,
)
from acf_jax.inference.discrepancy import FORMS, SIZES
from acf_jax.inference.free_curves import free_curves
from acf_jax.inference.parameters import Explanation

WIDER = min(size for size in SIZES if size > FORMS)
GRAVITY, FRICTION, ROBOT = ("gravity",), ("coulomb_friction",), ("unknown_robot",)


def _told(objectives: dict[Explanation, float]) -> dict[Explanation, float]:
    """Probabilities of explanations without a discrepancy that are all as free as one another."""
    found = posterior([Marginal(e, 0.0, x, 0.0) for e, x in objectives.items()])
    return dict(found.scored)


def test_probabilities_add_up_and_follow_the_evidence() -> None:
    same = _told({(): 500.0, GRAVITY: 500.0, FRICTION: 500.0, ROBOT: 500.0})
    assert sum(same.values()) == pytest.approx(1.0)
    assert same[()] / same[UNKNOWN] == pytest.approx(len(COMPONENTS), rel=1e-4)  # one of its places
    assert same[()] / same[GRAVITY] == pytest.approx(len(library()), rel=1e-4)
    clear = _told({(): 5000.0, GRAVITY: 500.0, FRICTION: 495.0, ROBOT: 505.0})
    assert clear[FRICTION] / clear[GRAVITY] == pytest.approx(np.exp(5.0), rel=1e-4)
    outside = _told({(): 5e4, GRAVITY: 2e4, FRICTION: 3e4, ROBOT: 500.0})
    assert outside[UNKNOWN] > 0.99


def test_every_number_of_laws_is_as_likely_before_data() -> None:
    """However many combinations of as many there are."""
    for count in (1, 2, 5):
        each = [log_prior(e) for e in combinations(library(), count)]
        assert logsumexp(each) == pytest.approx(log_prior(()), abs=1e-9)


def test_an_unknown_cause_is_as_likely_as_none_before_data() -> None:
    """At all components together, alone and beside laws."""
    for laws in ((), GRAVITY, ("gravity", "sensor_lag")):
        beside = [log_prior((*laws, curve)) for curve in free_curves()]
        assert logsumexp(beside) == pytest.approx(log_prior(laws))


def _of_conditions(explanation: Explanation, *each: float) -> Marginal:
    return Marginal(explanation, 0.0, -sum(each), 0.0, of_conditions=each)


def test_evidence_counts_for_less_where_conditions_disagree() -> None:
    """By 20 in all, of which each condition has its share, or one has all and others speak against it."""

    def of_gravity(*each: float) -> float:
        rows = [_of_conditions(GRAVITY, *each), _of_conditions(FRICTION, *(0.0 for _ in each))]
        return dict(posterior(rows).scored)[GRAVITY]

    alone = _told({GRAVITY: -20.0, FRICTION: 0.0})[GRAVITY]
    assert of_gravity(20.0) == pytest.approx(alone)  # of one condition nothing is known
    assert of_gravity(20 / 3, 20 / 3, 20 / 3) == pytest.approx(alone)
    # drawn anew the first condition is missing in (2/3)^3 = 8 of 27 data sets
    assert of_gravity(24.0, -2.0, -2.0) == pytest.approx(1 - 8 / 27, abs=0.05)


def test_an_explanation_is_as_probable_as_beside_all_discrepancies_together() -> None:
    rows = [Marginal((), 0.0, 600.0, 0.0), Marginal(GRAVITY, 0.0, 510.0, 0.0)]
    beside = [Marginal(GRAVITY, size, 505.0, 0.0) for size in SIZES]
    alone, both = posterior(rows), posterior([*rows, *beside])
    log_p = log_posterior([*rows, *beside])
    p = np.exp(log_p - log_p.max())
    assert dict(both.scored)[GRAVITY] == pytest.approx(p[1:].sum() / p.sum(), rel=1e-4)
    assert p[2:].sum() > p[1] and both.of(GRAVITY) == pytest.approx(alone.of(GRAVITY), abs=0.01)


def test_no_law_where_much_is_missing_is_an_unknown_cause() -> None:
    for size, share in ((0.03, 0.0), (0.1, 1.0)):
        rows = [Marginal((), size, 500.0, 0.0), Marginal(GRAVITY, size, 600.0, 0.0)]
        found = posterior(rows)
        assert dict(found.scored).get(UNKNOWN, 0.0) == pytest.approx(share, abs=1e-4)
        assert found.missed == size


def test_the_component_of_an_unknown_cause_is_told_by_its_curves_and_several_laws_count_each() -> None:
    sensor = ("unknown_sensor",)
    rows = [((), 5000.0), (ROBOT, 500.0), (sensor, 501.0), (("gravity", "sensor_lag"), 506.0)]
    found = posterior([Marginal(e, 0.0, x, 0.0) for e, x in rows])
    pair = dict(found.scored)[("gravity", "sensor_lag")]
    unknown = dict(found.scored)[UNKNOWN]
    assert found.of(ROBOT) + found.of(sensor) == pytest.approx(unknown)
    assert found.of(ROBOT) > found.of(sensor)
    where = found.components()
    assert where["robot"] == pytest.approx(found.of(ROBOT)) and where["contact"] == 0.0
    assert where["sensor"] == pytest.approx(found.of(sensor) + pair)
    assert where["actuator"] == pytest.approx(pair)


def test_the_best_free_curve_is_told_though_a_law_fits_better_by_any_factor() -> None:
    """An unknown cause may lead because all fits miss the force by far; its curves then have next to no probability."""
    contact, sensor = ("unknown_contact",), ("unknown_sensor",)
    rows = [Marginal((), 0.1, 400.0, 0.0), Marginal(("pad_bottoming",), 0.0, 500.0, 0.0)]
    rows += [
        Marginal(e, 0.0, x, 0.0) for e, x in ((contact, 2e6), (ROBOT, 9e4), (sensor, 4e4), (sensor, 5e4))
    ]
    found = posterior(rows)
    assert found.scored[0].explanation == UNKNOWN and found.scored[0].probability > 0.99
    curves = found.behind[UNKNOWN]
    assert curves[sensor] == pytest.approx(1.0) and sum(curves.values()) == pytest.approx(1.0)
    assert max(found.components().items(), key=lambda item: item[1])[0] == "sensor"
    assert found.of(contact) > 0.0  # odds of any two explanations exist


def test_the_credible_set_is_the_smallest_that_holds_95_percent() -> None:
    scored = [Scored(("a",), 0.6), Scored(("b",), 0.36), Scored((), 0.04)]
    assert credible_set(scored) == [("a",), ("b",)]


def test_what_is_learnt_is_few_numbers_with_their_origin() -> None:
    content = read_calibration()
    assert len(content["learnt"]) <= 6 and content["learnt"] == {"elsewhere": ELSEWHERE}
    assert content["command"] and content["runs"] and len(content["commit"]) == 40


def _with_changes(rows: dict[Explanation, tuple[float, tuple[float, ...]]]) -> list[Marginal]:
    return [Marginal(e, 0.0, -z, 0.0, changes) for e, (z, changes) in rows.items()]


def test_an_explanation_is_stated_by_the_laws_that_matter() -> None:
    """Small ones that stand in for one another are background, and do not part what is alike but for them."""
    rows: dict[Explanation, tuple[float, tuple[float, ...]]] = {
        ("gravity",): (0.0, ()),
        ("gravity", "sensor_lag"): (8.0, (20.0, 1.0)),
        ("fixture_mass", "gravity"): (7.0, (1.5, 20.0)),
        ("coulomb_friction",): (1.0, ()),
    }
    found = posterior(_with_changes(rows))
    assert found.scored[0].explanation == GRAVITY
    odds = {e: np.exp(z) / math.comb(len(library()), len(e)) for e, (z, _) in rows.items()}
    total = sum(odds.values())
    assert found.scored[0].probability == pytest.approx(1 - odds[FRICTION] / total, rel=1e-4)
    assert found.stated(("gravity", "sensor_lag")) == GRAVITY
    assert found.of(("gravity", "sensor_lag")) == pytest.approx(
        odds["gravity", "sensor_lag"] / total, rel=1e-3
    )
    assert sum(found.behind[GRAVITY].values()) == pytest.approx(1.0)


def test_beside_a_missing_cause_an_explanation_without_a_likely_law_is_unknown() -> None:
    """Where much is missing each law may stand in for what misses: unless one is likely, the cause is unknown."""

    def first(lead: float) -> Explanation:
        laws = {GRAVITY: lead, FRICTION: 0.1, ("sensor_lag",): 0.2}
        rows = [Marginal(e, WIDER, -z, 0.0) for e, z in laws.items()]
        return posterior([*rows, Marginal((), FORMS, 50.0, 0.0)]).scored[0].explanation

    assert first(lead=0.3) == UNKNOWN
    assert first(lead=5.0) == GRAVITY


def test_a_small_law_that_data_need_where_forms_may_be_wrong_is_stated() -> None:
    """A fixture of a hundredth of the force beside gravity, where all that fits has it."""
    pair, changes = ("fixture_mass", "gravity"), (1.5, 20.0)

    def stated(without_fixture: float) -> Explanation:
        exact = [Marginal(GRAVITY, 0.0, 300.0, 0.0), Marginal(pair, 0.0, 0.0, 0.0, changes)]
        beside = [
            Marginal(GRAVITY, FORMS, 150.0 + without_fixture, 0.0),
            Marginal(pair, FORMS, 150.0, 0.0, changes),
            Marginal(("coulomb_friction", "fixture_mass"), FORMS, 160.0, 0.0, changes[::-1]),
        ]
        return posterior([*exact, *beside]).scored[0].explanation

    assert stated(without_fixture=100.0) == pair
    assert stated(without_fixture=4.0) == GRAVITY  # exact forms alone need it


@pytest.mark.parametrize(
    "changes, small",
    [
        ((3.0, 3.0, 3.0), set()),
        ((10.0, 2.2, 0.1), {"b", "c"}),
        ((10.0, 2.4, 0.1), {"c"}),  # the largest alone holds less than 95 % of the squares
        ((0.1, 10.0, 0.0), {"a", "c"}),
        ((0.0, 0.0, 0.0), set()),
        ((), set()),
    ],
)
def test_laws_are_minor_beyond_the_largest_that_hold_95_percent(
    changes: tuple[float, ...], small: set[str]
) -> None:
    assert minor(Marginal(("a", "b", "c"), 0.0, 0.0, 0.0, changes)) == small

"""Other methods on the sets of blind runs: their formulas, what they read, and the one rule that scores them all."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from acf_jax.effects import library
from acf_jax.errors import InputError
from acf_jax.evidence.marginal import Marginal
from benchmarks.peers_diagnosis import criteria
from benchmarks.peers_diagnosis.cases import Case, Named, read_cases, read_measured, read_run
from benchmarks.peers_diagnosis.features import BINS, features
from benchmarks.peers_diagnosis.judge import judge, paired, share
from benchmarks.peers_diagnosis.table import table
from benchmarks.peers_diagnosis.traces import Traces
from validation.blind.answer import Class
from validation.worlds.interface import Rig
from validation.worlds.paper import contact_force, until_lost


def case_of(truth: tuple[str, ...], **other: object) -> Case:
    made = Case(
        name="one",
        kind="single",
        data=Path("one"),
        truth=truth,
        background=(),
        neighbours={},
        withheld="",
        classes=(),
        ours=Named(((truth, 1.0),), 10.0),
        evidence=(),
    )
    return replace(made, **other)  # type: ignore[arg-type]


# criteria


def test_criteria_by_hand() -> None:
    """k = 6 and 7, 50 samples and a prior for each parameter: n = 56 and 57."""
    assert criteria.size(()) == 6 and criteria.size(("gravity",)) == 7
    assert criteria.aicc(100.0, 6, 56) == pytest.approx(212 + 84 / 49)
    assert criteria.bic(100.0, 6, 56) == pytest.approx(224.15211, abs=1e-5)
    fits = [Marginal((), 0.0, 100.0, 0.0), Marginal(("gravity",), 0.0, 97.0, 0.0)]
    for criterion, weight in ((criteria.aicc, 0.84739), (criteria.bic, 0.71614)):
        scored = criteria.weigh(fits, 50, criterion)
        assert scored[0] == (("gravity",), pytest.approx(weight, abs=1e-4))
        assert sum(p for _, p in scored) == pytest.approx(1)


def test_free_curves_are_summed_up_as_unknown_and_discrepancies_left_out() -> None:
    fits = [
        Marginal((), 0.0, 200.0, 0.0),
        Marginal(("unknown_robot",), 0.0, 100.0, 0.0),
        Marginal(("gravity", "unknown_robot"), 0.0, 100.0, 0.0),
        Marginal(("gravity",), 0.02, 0.0, 0.0),
    ]
    scored = criteria.weigh(fits, 500, criteria.aicc)
    assert scored[0] == (("unknown",), pytest.approx(1.0))
    assert ("gravity",) not in dict(scored)


# the scoring rule


@pytest.mark.parametrize(
    ("said", "probability", "right", "wrong"),
    [
        (("gravity",), 0.5, True, False),
        (("sensor_lag",), 0.96, False, True),
        (("sensor_lag",), 0.94, False, False),
        (("unknown",), 0.99, False, False),
        ((), 0.99, False, False),
        (("end_stop",), 0.99, True, False),
    ],
)
def test_one_rule_for_every_method(
    said: tuple[str, ...], probability: float, right: bool, wrong: bool
) -> None:
    """A wrong name counts when sure; a class that our diagnosis computed counts for all."""
    case = case_of(("gravity",), classes=(Class(effects=("end_stop", "gravity")),))
    found = judge(case, Named(((said, probability), (("pad_mass",), 1 - probability)), 1.0))
    assert (found.right, found.wrong_when_sure) == (right, wrong)
    assert found.log_loss == pytest.approx(-np.log(probability if said == ("gravity",) else 1e-3))


def test_an_only_answer_is_sure_and_has_no_log_loss() -> None:
    found = judge(case_of(()), Named(((("gravity",), 1.0),), 1.0, is_sure=True))
    assert found.wrong_when_sure and np.isnan(found.log_loss)


def test_small_effects_may_be_named() -> None:
    lifelike = case_of(("gravity",), background=("sensor_lag",))
    assert judge(lifelike, Named(((("gravity", "sensor_lag"), 0.6),), 1.0)).right
    assert not judge(lifelike, Named(((("sensor_lag",), 0.6),), 1.0)).right


def test_intervals() -> None:
    """Clopper and Pearson's of 8 of 10; a difference that is the same in all cases has no width."""
    assert share([True] * 8 + [False] * 2) == pytest.approx((0.8, 0.4439, 0.9748), abs=1e-4)
    assert paired([1, 2, 3], [0, 1, 2]) == pytest.approx((1, 1, 1))
    low, high = paired([1, 0] * 20, [0, 0] * 20)[1:]
    assert 0.3 < low < 0.4 and 0.6 < high < 0.7


def test_table_holds_each_method_beside_ours() -> None:
    cases = [case_of(("gravity",)), case_of((), kind="none")]
    ours = [judge(case, case.ours) for case in cases]
    other = [judge(case, Named(((("gravity",), 1.0),), 2.0, is_sure=True)) for case in cases]
    rows = table(cases, {"ours": ours, "other": other}).splitlines()
    assert rows[0].endswith("| none | single |")
    assert "| 2/2 (16% to 100%) |" in rows[2] and rows[2].endswith("| 1/1 | 1/1 |")
    assert "| 1/2 " in rows[3] and "-50 (" in rows[3] and rows[3].endswith("| 0/1 | 1/1 |")


# what is read


def write_run(run: Path, row: dict[str, object] | None) -> None:
    data, result = run / "sets" / "case-000", run / "results" / "case-000"
    data.mkdir(parents=True)
    result.mkdir(parents=True)
    (data / "dataset.yaml").write_text("schema: acf-gap-dataset/1\n")
    diagnosis = {
        "verdict": "ambiguous",
        "explanations": [{"effects": ["gravity"], "probability": 0.7}, {"effects": [], "probability": 0.3}],
        "credible_set": [["gravity"], []],
        "indistinguishable": [{"effects": ["end_stop", "gravity"]}],
        "where": {"component": {"actuator": 1.0}},
        "shrinkage": {"force": None},
        "parameters": {},
        "excluded_trials": [],
        "evidence": [
            {
                "effects": [],
                "discrepancy": 0.0,
                "objective": 9.0,
                "log_occam": -1.0,
                "force_changes_n": [],
                "log_likelihood_of_conditions": [],
            }
        ],
    }
    (result / "diagnosis.json").write_text(json.dumps(diagnosis))
    (result / "seconds.txt").write_text("12.5\n")
    if row is None:
        (data / "answer.yaml").write_text("effects: [gravity]\nbackground: {sensor_lag: 0.01}\n")
    else:
        (run / "results" / "score.json").write_text(json.dumps({"rows": [row]}))


ROW = {
    "set": "case-000",
    "kind": "withheld",
    "truth": ["unknown"],
    "background": [],
    "neighbours": {"end_stop": 0.2},
}


def test_a_scored_run_is_read(tmp_path: Path) -> None:
    write_run(tmp_path, ROW)
    (tmp_path / "sets" / "withheld.json").write_text('{"case-000": "coulomb_friction"}')
    (case,) = read_run(tmp_path)
    assert (case.kind, case.truth, case.withheld) == ("unknown", ("unknown",), "coulomb_friction")
    assert case.ours == Named(((("gravity",), 0.7), ((), 0.3)), 12.5)
    assert case.evidence == (Marginal((), 0.0, 9.0, -1.0),)
    assert not judge(case, case.ours).right  # gravity is no neighbour, end_stop is
    assert judge(case, Named(((("end_stop",), 0.7),), 1.0)).right


def test_sets_with_their_answers_beside_them_are_read(tmp_path: Path) -> None:
    write_run(tmp_path, None)
    (case,) = read_cases(tmp_path / "sets", tmp_path / "results")
    assert (case.truth, case.background) == (("gravity",), ("sensor_lag",))


def test_measured_sets_are_read_and_judged_as_their_benchmark_judges_them(tmp_path: Path) -> None:
    write_run(tmp_path, None)
    for name in ("cognifly/cognifly_lag", "cognifly/cognifly_label"):  # the second asks for faulty trials
        shutil.copytree(tmp_path / "results/case-000", tmp_path / "diagnosed" / name)
    (case,) = read_measured(tmp_path / "sets", tmp_path / "diagnosed")
    assert (case.name, case.kind, case.data) == (
        "cognifly_lag", "measured", tmp_path / "sets/cognifly/cognifly_lag",
    )  # fmt: skip
    found = judge(case, case.ours)  # gravity, of which no rig is free
    assert not found.right and not found.wrong_when_sure
    surely = judge(case, Named(((("gravity",), 0.96), (("gravity", "sensor_lag"), 0.04)), 1.0))
    assert surely.wrong_when_sure and surely.log_loss == pytest.approx(-np.log(0.04))
    assert judge(case, Named(((("sensor_lag",), 0.96),), 1.0)).right
    assert not judge(case, Named(((("robot_compliance", "sensor_lag"), 0.96),), 1.0)).right  # it has no robot
    with pytest.raises(InputError, match="holds no diagnosis of a measured set"):
        read_measured(tmp_path, tmp_path / "sets")


def test_what_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="sets: no such folder"):
        read_run(tmp_path)
    write_run(tmp_path, {"set": "case-000"})
    with pytest.raises(InputError, match=r"score\.json: rows"):
        read_run(tmp_path)
    (tmp_path / "results" / "score.json").unlink()
    with pytest.raises(InputError, match=r"case-000: has no answer\.yaml"):
        read_run(tmp_path)


# the classifier and sparse regression


def traces_at(rate: float, repeats: int = 1, ripple: float = 8.0) -> Traces:
    """Noise-free traces of a rig whose reading has a ripple, N at 0.2 m/s, that grows with the speed."""
    rig = Rig(m=2.0, d=40.0, k_f=3000.0, k_c=2e5)
    v_e, f_p = (np.repeat(a, repeats) for a in ([0.1, 0.2, 0.3, 0.1, 0.2, 0.3], [60.0] * 3 + [100.0] * 3))
    time = np.tile(np.arange(1, int(0.03 * rate)) / rate, (v_e.size, 1))
    force = until_lost(contact_force(rig, v_e[:, None], f_p[:, None], time))
    reading = force + ripple * (v_e[:, None] / 0.2) * np.sin(2 * np.pi * 300 * time)
    prior = np.array([2.0, 40.0, 3000.0, 2e5])
    return Traces(
        v_e,
        f_p,
        time,
        reading,
        force > 0,
        np.full(v_e.size, 1 / rate),
        1.0,
        1.0,
        (0.004, 0.004),
        prior,
        prior * [0.02, 0.3, 0.5, 0.1],
    )


def test_features_depend_neither_on_sampling_rate_nor_on_number_of_trials() -> None:
    """But for how many samples there are, and how far data move a rig from its prior: the more, the further."""
    one, fine, many = (features(t) for t in (traces_at(8e3), traces_at(24e3), traces_at(8e3, repeats=3)))
    flat = features(traces_at(8e3, ripple=1.0))
    curves = 2 * 4 * BINS
    sizes, certain, context = slice(curves, curves + 3), curves + 3, slice(-7, None)
    assert one.shape == fine.shape == many.shape
    for other in (fine, many):
        assert np.corrcoef(one[:curves], other[:curves])[0, 1] > 0.99
        assert np.abs(one - other)[sizes].max() < 0.1
        np.testing.assert_allclose(one[context], other[context])
        assert one[certain] - other[certain] == pytest.approx(0.5 * np.log(3), abs=0.03)
    assert (one - flat)[sizes].min() > 1


def test_drawn_forms_follow_the_prior() -> None:
    from acf_jax.inference.parameters import PRIOR_WIDTH, every_effect
    from benchmarks.peers_diagnosis.draws import direction

    rng = np.random.default_rng(0)
    for name in library():
        known = every_effect()[name].parameters()
        values, strong = direction(rng, name)
        total = sum(
            abs(v) / (PRIOR_WIDTH * p.scale) for v, p in zip(values, known, strict=True) if not p.shape
        )
        assert 0 < total <= 1 + 1e-12
        for v, p, is_strong in zip(values, known, strong, strict=True):
            assert is_strong != p.shape and (not p.shape or p.low <= v <= p.high)

"""Peers that other packages bring: BayesFlow's classifier and PySINDy's regression."""

import jax
import numpy as np
import pytest

from acf_jax.effects import library
from tests.needs import need_module

pytestmark = pytest.mark.long


def test_a_withheld_law_leaves_its_probability_to_the_other_classes() -> None:
    need_module("bayesflow", 'pip install ".[peers]"')
    from benchmarks.peers_diagnosis.classifier import CLASSES, rank

    laws = len(library())
    assert len(set(CLASSES)) == len(CLASSES) == 1 + laws + laws * (laws - 1) // 2 + 1
    p = np.zeros(len(CLASSES))
    for e, q in {
        ("gravity",): 0.5,
        ("gravity", "pad_mass"): 0.3,
        ("pad_mass",): 0.15,
        ("unknown",): 0.05,
    }.items():
        p[CLASSES.index(e)] = q
    assert rank(p)[:2] == [(("gravity",), pytest.approx(0.5)), (("gravity", "pad_mass"), pytest.approx(0.3))]
    known = rank(p, withheld="gravity")
    assert known[:2] == [(("pad_mass",), pytest.approx(0.75)), (("unknown",), pytest.approx(0.25))]
    assert all("gravity" not in e for e, _ in known)


def test_a_classifier_learns_what_its_sets_tell(monkeypatch: pytest.MonkeyPatch) -> None:
    need_module("bayesflow", 'pip install ".[peers]"')
    from benchmarks.peers_diagnosis import classifier

    monkeypatch.setattr(classifier, "NETWORKS", 1)
    monkeypatch.setattr(classifier, "WIDTHS", (64,))
    rng = np.random.default_rng(0)
    some = [(), ("gravity",), ("gravity", "pad_mass"), ("unknown",), ("end_stop", "gravity", "pad_mass")]
    told = [some[k % 5] for k in range(750)]
    signs = np.array([["gravity" in e, "pad_mass" in e, "unknown" in e] for e in told]) * 4.0
    with jax.numpy_rank_promotion("allow"):  # Keras relies on it
        trained = classifier.train(
            signs + 0.3 * rng.standard_normal(signs.shape), told, np.arange(len(told)) // 5
        )
        p = trained.probabilities(np.array([[4.0, 4.0, 0.0], [0.0, 0.0, 4.0], [0.0, 0.0, 0.0]]))
    np.testing.assert_allclose(p.sum(1), 1.0)
    for one, truth in zip(p, (("gravity", "pad_mass"), ("unknown",), ()), strict=True):
        first, probability = classifier.rank(one)[0]
        assert first == truth and probability > 0.8


def test_sparse_regression_picks_the_term_that_acts() -> None:
    need_module("pysindy", 'pip install ".[peers]"')
    from benchmarks.peers_diagnosis.sindy import pick

    rng = np.random.default_rng(0)
    columns, _ = np.linalg.qr(rng.standard_normal((400, 6)))
    noise = rng.standard_normal(400)
    kept, rest = pick(columns, 50 * columns[:, 2] + noise, 400.0)
    assert kept == [2] and rest.std() == pytest.approx(1, abs=0.15)
    assert pick(columns, noise, 400.0)[0] == []


def test_sparse_regression_keeps_no_term_that_is_a_combination_of_others() -> None:
    need_module("pysindy", 'pip install ".[peers]"')
    from benchmarks.peers_diagnosis.sindy import independent_of

    columns, _ = np.linalg.qr(np.random.default_rng(0).standard_normal((40, 3)))
    both = (columns[:, :1] + columns[:, 1:2]) / np.sqrt(2)
    kept = independent_of(np.hstack([columns, both, columns[:, 2:]]))
    assert len(kept) == 3 and len({0, 1, 3} & set(kept)) == 2 and len({2, 4} & set(kept)) == 1

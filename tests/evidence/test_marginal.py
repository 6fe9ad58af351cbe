"""Marginal likelihoods, against a nested sampler and against plain integration."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

from acf_jax.errors import InputError
from acf_jax.evidence.marginal import marginal, read_evidence
from acf_jax.evidence.strengths import SIZES, of_size, ways, weigh
from acf_jax.inference.discrepancy import discrepancy
from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.free_curves import free_curves
from acf_jax.inference.observations import Discrepancy, Observations
from acf_jax.inference.parameters import begin
from benchmarks.log_evidence import nested
from tests.imagined import RIG, imagined

FORCE = 0.6  # N, a little more than can just be told


@pytest.fixture(scope="module")
def few() -> Observations:
    """Three trials of a rig with a small constant force, in noise."""
    o = imagined("gravity", (FORCE,)).subset(np.arange(12) % 5 == 0)
    noise = o.noise.std * np.random.default_rng(1).standard_normal(o.force.shape)
    return replace(o, force=np.where(o.used, o.force + noise, 0.0))


@pytest.fixture(scope="module")
def law(few: Observations) -> Fit:
    return fit(few, ("gravity",), begin(RIG.values, [FORCE]), warm=True)


@pytest.mark.long
def test_laplace_agrees_with_a_nested_sampler(few: Observations, law: Fit) -> None:
    """Of an explanation without a law, and of one whose prior is flat in the logarithm of its size."""
    none = fit(few, (), begin(RIG.values), warm=True)
    for fitted in (none, law):
        assert marginal(fitted).log_z == pytest.approx(nested(few, fitted, live=60), abs=1.0)


@pytest.mark.parametrize(("size", "std"), [(0.4, 0.1), (0.05, 0.02), (3.0, 0.01)])
def test_the_prior_of_a_size_is_flat_in_its_logarithm(size: float, std: float) -> None:
    """The average of the likelihood over it, against Laplace's of a normal prior that it takes the place of."""
    low, high = SIZES[0] * std, SIZES[-1] * std
    flat = quad(
        lambda x: np.exp(-0.5 * ((x - size) / std) ** 2) / (x * np.log(high / low)),
        max(low, size - 9 * std),
        min(high, size + 9 * std),
        epsabs=0,
    )[0]
    normal = np.log(std) - 0.5 * size**2
    correction = of_size(np.array([size]), np.array([[std**2]]))
    assert normal + correction == pytest.approx(np.log(flat), abs=0.1)


def test_strengths_that_end_at_nothing_are_no_gain() -> None:
    """Of two that together are far below what can be told, how small they are says nothing."""
    variance = np.diag([0.1**2, 0.1**2])
    tiny, small = (of_size(np.full(2, size), variance) for size in (1e-29, 1e-3))
    assert tiny == pytest.approx(small, abs=0.1)


def test_an_effect_that_does_nothing_costs_as_much_as_sizes_that_are_not_seen(
    few: Observations, law: Fit
) -> None:
    idle = fit(few, ("gravity",), begin(RIG.values, [0.0]), warm=True, iterations=0)
    assert marginal(idle).log_z < marginal(law).log_z


def test_a_free_curve_of_which_data_need_one_term_is_as_good_as_the_law(few: Observations, law: Fit) -> None:
    """But for the many ways in which it might have acted; with all its terms it is far less."""
    curve = free_curves()["unknown_actuator"]
    first = [FORCE if p.name == "constant_n" else p.scale * p.shape for p in curve.parameters()]
    free = fit(few, ("unknown_actuator",), begin(RIG.values, first), warm=True)
    found = weigh(free).ways
    best = max(found, key=lambda way: found[way])
    assert len(best) <= 2 < len(max(found, key=len)) and found[best] > found[max(found, key=len)] + 5
    assert marginal(free).log_z + np.log(ways("unknown_actuator")) == pytest.approx(
        marginal(law).log_z + np.log(ways("gravity")), abs=4.0
    )


def test_a_discrepancy_explains_what_no_law_does_and_costs_its_freedom(few: Observations, law: Fit) -> None:
    waves = discrepancy(few, 0.01)
    silent = fit(few, (), begin(RIG.values), warm=True)
    beside = fit(replace(few, discrepancy=waves), (), silent.theta, silent.nuisance, warm=True)
    assert beside.objective < silent.objective
    assert marginal(beside, 0.01).log_occam < marginal(silent).log_occam


def test_the_waves_of_a_discrepancy_are_together_as_large_as_the_force(few: Observations) -> None:
    """Those of a trial alone the root of two larger in each of two repeats."""
    once = discrepancy(few, 0.1)
    twice = discrepancy(replace(few, condition=np.array([0, 0, 1])), 0.1)
    np.testing.assert_allclose(twice.own[:2], np.sqrt(2) * once.own[:2])
    np.testing.assert_allclose(twice.own[2], once.own[2])
    np.testing.assert_allclose(twice.shared, once.shared)
    end = few.time[few.used].max()
    within = few.used & (few.time > 0.2 * end) & (few.time < 0.8 * end)
    size = (once.own**2).sum(1) + (once.shared**2).sum(1)
    assert size[within].mean() == pytest.approx(0.01 * (few.force[within] ** 2).mean(), rel=0.3)


def test_what_all_trials_share_costs_less_than_the_same_of_each(few: Observations) -> None:
    """A share of the force that no rig has, alike in all trials, beside the two halves of a discrepancy."""
    waves = discrepancy(few, 0.01)
    bent = replace(few, force=few.force + 2 * waves.shared[:, 1])
    start = fit(few, (), begin(RIG.values), warm=True)

    def log_z(own: np.ndarray, shared: np.ndarray) -> float:
        beside = replace(bent, discrepancy=Discrepancy(own, shared))
        found = fit(beside, (), start.theta, start.nuisance, warm=True)
        assert found.u.shape == (6 + shared.shape[1],) and found.common.shape == (2 + shared.shape[1],)
        return marginal(found, 0.01).log_z

    assert log_z(np.zeros_like(waves.own), waves.shared) > log_z(waves.own, np.zeros_like(waves.own)) + 3


def test_the_waves_are_fast_right_after_contact_alone(few: Observations) -> None:
    """A quarter of the changes of sign of the fastest wave lie in the first fifth of the time and more."""
    wave = discrepancy(few, 0.01).shared[0, -1][few.used[0]]
    time = few.time[0][few.used[0]]
    turns = time[np.flatnonzero(np.diff(np.sign(wave)))]
    assert (turns < 0.2 * time.max()).sum() > 0.25 * len(turns)


def test_evidence_of_another_version_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "diagnosis.json"
    file.write_text(
        '{"evidence": [{"effects": ["gravity"], "discrepancy": 0.0, "objective": 9.0, "log_occam": -1.0}]}'
    )
    with pytest.raises(InputError, match=r"diagnosis.json: evidence: .*; diagnose again"):
        read_evidence(file)
    file.write_text("{}")
    assert read_evidence(file) == ()

"""The shrinkage of the gap where what is left is known."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from acf_jax.diagnosis import shrinkage
from acf_jax.diagnosis.heldout import HeldOut
from acf_jax.diagnosis.shrinkage import Belief, Shrinkage, left_elsewhere, peak_shrinkage
from acf_jax.inference.fit import Fit
from acf_jax.inference.observations import Observations

CONDITIONS, REPEATS, GAP = 6, 4, 2000.0  # GAP: mean square of what the recalibrated model misses, N^2
FORCE = 1000.0  # N
NO_FITS = cast(tuple[Fit, Fit], (None, None))
SURE = Belief(right=1.0, discrepancy={0.0: 1.0})


def _force(
    monkeypatch: pytest.MonkeyPatch,
    left: float,
    samples: int,
    late: float = 0.0,
    belief: Belief = SURE,
    gap: float = GAP,
    noise: float = 50.0,
) -> Shrinkage | None:
    """Of trials with this mean square left beside the noise, whose parameters alone leave 4 N^2."""
    rng = np.random.default_rng(0)
    shape = (CONDITIONS * REPEATS, samples)
    held = [
        HeldOut(rng.normal(0, np.sqrt(noise + square), shape), np.full(shape, noise), np.ones(1), np.ones(1))
        for square in (gap, left)
    ]
    trials: Any = SimpleNamespace(
        traced=np.ones(shape, bool),
        condition=np.repeat(np.arange(CONDITIONS), REPEATS),
        force=np.full(shape, FORCE),
    )
    possible = tuple(np.full(shrinkage.DRAWS, value) for value in (4.0, late, GAP))
    monkeypatch.setattr(shrinkage, "_possible_errors", lambda *_: possible)
    monkeypatch.setattr(shrinkage, "ELSEWHERE", 200.0)
    found = left_elsewhere(cast(Observations, trials), NO_FITS, (held[0], held[1]), belief, 0)
    return None if found is None else Shrinkage.of(found)


def test_held_out_conditions_decide_where_they_are_many(monkeypatch: pytest.MonkeyPatch) -> None:
    found = _force(monkeypatch, left=80.0, samples=20000)
    assert found and found.value == pytest.approx(1 - (80 / GAP) ** 0.5, abs=0.01)
    assert found.ci95[0] < found.value < found.ci95[1] < 1


def test_what_the_noise_hides_is_what_the_parameters_leave_open(monkeypatch: pytest.MonkeyPatch) -> None:
    few, many = (_force(monkeypatch, left=4.0, samples=n) for n in (20, 20000))
    assert few and many
    for found in (few, many):
        assert found.ci95[0] < 1 - (4 / GAP) ** 0.5 < found.ci95[1]
    assert few.ci95[0] < many.ci95[0]


def test_a_delay_that_may_be_the_rigs_widens_the_interval(monkeypatch: pytest.MonkeyPatch) -> None:
    on_time, late = (_force(monkeypatch, left=4.0, samples=20000, late=square) for square in (0.0, 100.0))
    assert on_time and late and late.ci95[0] < on_time.ci95[0] - 0.1


def test_what_may_be_wrong_is_trusted_less(monkeypatch: pytest.MonkeyPatch) -> None:
    """A free curve is no law; where few samples were held out they do not say that it was right."""
    sure, doubtful, free = (
        _force(monkeypatch, left=4.0, samples=3, belief=Belief(p, {0.0: 1.0})) for p in (1.0, 0.5, 0.0)
    )
    assert sure and doubtful and free
    assert free.ci95[0] < doubtful.ci95[0] < sure.ci95[0]


def test_a_discrepancy_comes_back_on_other_conditions(monkeypatch: pytest.MonkeyPatch) -> None:
    """A hundredth of 1,000 N is a mean square of 100 N^2, a fifth of the gap's root."""
    silent, loud = (
        _force(monkeypatch, left=4.0, samples=3, belief=Belief(1.0, {size: 1.0})) for size in (0.0, 0.01)
    )
    assert silent and loud
    assert loud.value < silent.value - 0.1 and loud.ci95[0] < 1 - (100 / GAP) ** 0.5


def test_conditions_that_differ_widen_the_interval() -> None:
    random = np.random.default_rng(0)
    alike = shrinkage._as_elsewhere(np.full(shrinkage.RESAMPLES, 1.0), 6, random)
    assert (alike == 1.0).all()
    few, many = (
        shrinkage._as_elsewhere(np.exp(random.normal(0, 0.2, shrinkage.RESAMPLES)), n, random)
        for n in (3, 30)
    )
    assert np.log(many).std() == pytest.approx(0.2 * np.sqrt(2 * 30 / 27), rel=0.1)
    assert np.quantile(few, 0.975) > 1.3 * np.quantile(many, 0.975)


def test_without_a_gap_nothing_shrinks(monkeypatch: pytest.MonkeyPatch) -> None:
    assert _force(monkeypatch, left=0.0, gap=-25.0, samples=2000) is None


def test_the_shrinkage_of_the_peak() -> None:
    condition = np.repeat(np.arange(5), 3)
    measured = np.full(15, 100.0)
    off = np.linspace(0.5, 1.5, 15)
    held = [HeldOut(np.zeros((15, 1)), np.zeros((15, 1)), measured + by, measured) for by in (10 * off, off)]
    found = peak_shrinkage((held[0], held[1]), condition, 0)
    assert found and found.value == pytest.approx(0.9)
    assert found.ci95[0] <= 0.9 <= found.ci95[1] <= 1
    perfect = HeldOut(np.zeros((15, 1)), np.zeros((15, 1)), measured, measured)
    assert peak_shrinkage((perfect, held[1]), condition, 0) is None

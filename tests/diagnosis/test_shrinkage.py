"""The shrinkage of the gap where what is left is known."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from acf_jax.diagnosis import shrinkage
from acf_jax.diagnosis.heldout import HeldOut
from acf_jax.diagnosis.shrinkage import FREE, LAW, Form, Shrinkage, force_shrinkage, form_of, peak_shrinkage
from acf_jax.inference.fit import Fit
from acf_jax.inference.observations import Observations

CONDITIONS, REPEATS, GAP = 6, 4, 2000.0  # GAP: mean square of what the recalibrated model misses, N^2
NO_FITS = cast(tuple[Fit, Fit], (None, None))


def _force(
    monkeypatch: pytest.MonkeyPatch,
    left: float,
    samples: int,
    late: float = 0.0,
    form: Form = LAW,
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
    )
    possible = [np.full(shrinkage.DRAWS, value) for value in (4.0, late, GAP)]
    monkeypatch.setattr(shrinkage, "_possible_errors", lambda *_: possible)
    return force_shrinkage(cast(Observations, trials), NO_FITS, (held[0], held[1]), form, 0)


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


def test_a_delay_that_may_be_the_sensors_widens_the_interval(monkeypatch: pytest.MonkeyPatch) -> None:
    on_time, late = (_force(monkeypatch, left=4.0, samples=20000, late=square) for square in (0.0, 100.0))
    assert on_time and late and late.ci95[0] < on_time.ci95[0] - 0.1


def test_a_free_curve_is_trusted_less_than_a_law(monkeypatch: pytest.MonkeyPatch) -> None:
    law, free = (_force(monkeypatch, left=4.0, samples=2000, form=form) for form in (LAW, FREE))
    assert law and free and free.ci95[0] < law.ci95[0] - 0.3


def test_a_doubtful_explanation_is_trusted_less(monkeypatch: pytest.MonkeyPatch) -> None:
    corrected: Any = SimpleNamespace(explanation=("gravity",))
    sure, doubtful = (
        _force(monkeypatch, left=4.0, samples=2000, form=form_of(corrected, p)) for p in (1.0, 0.5)
    )
    assert sure and doubtful and doubtful.value == sure.value
    assert doubtful.ci95[0] == pytest.approx(sure.ci95[0] - 0.5 * shrinkage.WRONG)


def test_without_a_gap_nothing_shrinks(monkeypatch: pytest.MonkeyPatch) -> None:
    assert _force(monkeypatch, left=0.0, gap=-25.0, samples=2000) is None


def test_the_shrinkage_of_the_peak() -> None:
    condition = np.repeat(np.arange(5), 3)
    measured = np.full(15, 100.0)
    off = np.linspace(0.5, 1.5, 15)
    held = [HeldOut(np.zeros((15, 1)), np.zeros((15, 1)), measured + by, measured) for by in (10 * off, off)]
    found = peak_shrinkage((held[0], held[1]), condition, LAW, 0)
    assert found and found.value == pytest.approx(0.9)
    assert found.ci95[0] <= 0.9 - shrinkage.LEAST_WIDTH < 0.9 + shrinkage.LEAST_WIDTH <= found.ci95[1] <= 1
    perfect = HeldOut(np.zeros((15, 1)), np.zeros((15, 1)), measured, measured)
    assert peak_shrinkage((perfect, held[1]), condition, LAW, 0) is None

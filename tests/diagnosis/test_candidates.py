"""From where free curves are fitted, with fits that are made up."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from acf_jax.diagnosis import candidates
from acf_jax.effects import AbstractOscillator, library
from acf_jax.inference.baseline import Ground
from acf_jax.inference.fit import fit
from acf_jax.inference.free_curves import free_curves
from acf_jax.inference.parameters import Measures, begin, every_effect, starts
from tests.imagined import imagined

RIPPLE = [p.name for p in every_effect()["unknown_robot"].parameters()].index("ripple_hz")


@pytest.fixture
def begun(monkeypatch: pytest.MonkeyPatch) -> list[tuple[float, int]]:
    """The ripple of each start of the robot's free curve that was fitted, and its iterations; 300 fits best."""
    seen: list[tuple[float, int]] = []

    def fit(_: Any, explanation: Any, start: np.ndarray, *rest: Any, iterations: int, **more: Any) -> Any:
        ripple = float(start[4 + RIPPLE])
        seen.append((ripple, iterations))
        return SimpleNamespace(explanation=explanation, objective=abs(ripple - 300.0) + 10.0)

    monkeypatch.setattr(candidates, "fit", fit)
    monkeypatch.setattr(candidates, "go_on", lambda _, glance: glance)
    return seen


GROUND: Any = SimpleNamespace(
    observations=SimpleNamespace(prior=SimpleNamespace(values=np.ones(4)), n_used=100, measures=Measures()),
    fitted=SimpleNamespace(theta=np.ones(6), common=np.zeros(2), nuisance=None, objective=1000.0),
)


def curve(name: str, objective: float) -> Any:
    return SimpleNamespace(explanation=(name,), objective=objective)


def test_a_free_curve_gets_a_glance_from_each_of_its_starts(begun: list[tuple[float, int]]) -> None:
    found = candidates.fit_further(GROUND, curve("unknown_robot", 1000.0))
    assert found.objective == 10.0
    assert begun == [(start[RIPPLE], candidates.GLANCE) for start in starts("unknown_robot")]


def test_a_better_fit_of_a_free_curve_stands(begun: list[tuple[float, int]]) -> None:
    known = curve("unknown_robot", 5.0)
    assert candidates.fit_further(GROUND, known) is known


def test_a_ring_as_large_as_the_force_is_seen_at_a_glance() -> None:
    """What is left without it is so much that the refitted rig leads astray: it is looked for from the prior."""
    observations = imagined("fixture_mass", (0.2, 4e7, 7e-6))
    ground = Ground.of(observations, candidates.fit_nominal(observations))
    seen = candidates.glances(ground, "fixture_mass")
    assert min(glance.objective for glance in seen) < 1e-3 * ground.fitted.objective


def test_a_ring_near_the_sampling_rate_is_told_from_those_that_the_samples_show() -> None:
    """At 10.9 kHz, of samples at 10 kHz: what promises most is 2.4 kHz."""
    observations = imagined("fixture_mass", (0.007, 3.3e7, 1.3e-5))
    ground = Ground.of(observations, candidates.fit_nominal(observations))
    best, *others = ground.promises("fixture_mass")
    assert best.parameters[0] > 0.1 and any(p.parameters[0] < 0.01 for p in others[: candidates.VALLEYS - 1])
    found = candidates.fit_single(ground, "fixture_mass")
    assert found.objective < 0.01 * ground.fitted.objective and found.physical[4] < 0.01


def test_what_takes_longest_is_fitted_first() -> None:
    order = candidates.singles(["gravity", *free_curves(), "sensor_resonance"])
    curves = {(name,) for name in free_curves()}
    assert set(order[: len(curves)]) == curves
    assert order[len(curves) :] == [("sensor_resonance",), ("gravity",)]


OSCILLATORS = [name for name, law in library().items() if issubclass(law, AbstractOscillator)]


@pytest.mark.parametrize("name", OSCILLATORS)
def test_an_oscillator_has_the_mode_that_it_is_begun_at(name: str) -> None:
    law = library()[name]
    assert issubclass(law, AbstractOscillator)
    assert law(*law.of_mode(9e3, 0.1)).mode() == pytest.approx((9e3, 0.1))
    assert len(OSCILLATORS) > 1


def test_an_oscillator_is_fitted_from_the_mode_where_another_one_ended() -> None:
    """A heavily damped mass on the sensor, whose own fit is held up far away; other fits stay as they are."""
    observations = imagined("fixture_mass", (0.02, 3e7, 3e-5))
    nominal = candidates.fit_nominal(observations)
    far = begin(nominal.theta[:4], [5.0, 3e7, 1e-5])
    lost = fit(observations, ("fixture_mass",), far, nominal.nuisance, iterations=0)
    lag = fit(observations, ("sensor_lag",), begin(nominal.theta[:4], [3e-5, 0.6]))
    found, kept, same = candidates.exchange_modes(observations, [lost, lag, nominal])
    assert found.objective < lag.objective < 0.01 * lost.objective
    assert kept is lag and same is nominal

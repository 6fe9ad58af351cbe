"""The price of an effect's freedom, against integrals that can be done by hand."""

from dataclasses import replace

import numpy as np
import pytest

from acf_jax.dataset import Noise
from acf_jax.diagnosis.candidates import fit_nominal, fit_single
from acf_jax.effects import library
from acf_jax.evidence.occam import SIZES, volumes
from acf_jax.inference.baseline import Ground
from acf_jax.inference.fit import Fit
from acf_jax.inference.forward import Grid, forward, plain_forward
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import every_effect
from tests.imagined import CONDITIONS, RIG, imagined


def fitted(observations: Observations, *names: str) -> tuple[Fit, list[Fit]]:
    nominal = fit_nominal(observations)
    ground = Ground.of(observations, nominal)
    return nominal, [fit_single(ground, name) for name in names]


@pytest.fixture(scope="module")
def weak() -> Observations:
    """A gain error of 2 % beside 1 N of noise."""
    ideal = imagined("sensor_scale", (0.02,))
    noise = np.random.default_rng(1).standard_normal(ideal.force.shape)
    return replace(ideal, noise=Noise(1.0), force=ideal.force + noise * ideal.used)


def test_the_share_of_an_effect_of_one_form_is_that_of_its_sizes(weak: Observations) -> None:
    nominal, (scale,) = fitted(weak, "sensor_scale")
    z = np.sqrt(2 * (nominal.objective - scale.objective))
    assert 3.0 < z < 12.0
    # either sign is as probable before the data, and the wrong one explains nothing
    expected = np.mean([np.exp(sign * SIZES * z - SIZES**2 / 2 - z**2 / 2) for sign in (1, -1, 1)])
    assert volumes(weak, nominal, [scale])["sensor_scale"] == pytest.approx(np.log(expected), abs=0.1)


def test_an_effect_with_a_frequency_to_choose_is_dearer(weak: Observations) -> None:
    nominal, fits = fitted(weak, "sensor_scale", "sensor_resonance")
    shares = volumes(weak, nominal, fits)
    assert shares["sensor_resonance"] < shares["sensor_scale"] - 1.0


@pytest.mark.parametrize("name", sorted(library()))
def test_every_effect_has_a_share(weak: Observations, name: str) -> None:
    """Where its signature can be seen at all: nowhere above one, nowhere none."""
    nominal, fits = fitted(weak, name)
    (share,) = volumes(weak, nominal, fits).values()
    assert -12.0 < share < 0.1


def test_peaks_alone_show_no_signature(weak: Observations) -> None:
    peaks = replace(weak, peak_only=np.ones(len(CONDITIONS), bool))
    assert volumes(peaks, fit_nominal(weak), []) == {}


@pytest.mark.parametrize("name", ["contact_damping", "sensor_lag", "end_stop"])
def test_forces_without_derivatives_are_the_same(name: str) -> None:
    values = [p.starts[-1] for p in every_effect()[name].parameters()]
    theta, grid = np.array([[*RIG.values, *values], [*1.1 * RIG.values, *values]]), Grid(2e-5, 600)
    v_e, f_p = np.array([0.1, 0.3, 0.2]), np.array([40.0, 80.0, 120.0])
    sensed, contact = plain_forward((name,), theta, v_e, f_p, grid)
    for k, row in enumerate(theta):
        known = forward((name,), row, v_e, f_p, grid)
        np.testing.assert_allclose(sensed[k], known.sensed, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(contact[k], known.contact, rtol=1e-9, atol=1e-9)

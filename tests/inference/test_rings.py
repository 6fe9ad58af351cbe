"""Rings that trials do not share, found in repeats that are known to ring, and in none that are not."""

from dataclasses import replace

import numpy as np
import pytest

from acf_jax.diagnosis.candidates import fit_nominal
from acf_jax.inference import rings
from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.forward import Grid, forward
from acf_jax.inference.interpolation import at_times
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import begin
from acf_jax.inference.repeats import alike
from acf_jax.inference.ring import Ring
from acf_jax.inference.scatter import with_scatter
from acf_jax.inference.trigger import trigger_scatter
from tests.repeated import INTERVAL, RIG, repeated

TRUE = Ring(400.0, 3e-3, 8.0, 150.0, 1)


def ringing(ring: Ring = TRUE, seed: int = 0, **design: int) -> Observations:
    """Repeats that ring, each with a size and a phase of its own."""
    o = repeated(0.0, **design)
    parts = np.random.default_rng(seed).standard_normal((len(o.names), 2))
    return replace(o, force=o.force + np.einsum("ik,ikn->in", parts, ring.columns(o.time, o.force.max(1))))


def find_rings(o: Observations, fitted: Fit | None = None) -> tuple[Ring, ...]:
    """By the repeats alone, or as a fit leaves them."""
    return rings.find_rings(o, alike(o, fitted))


def test_a_ring_is_found() -> None:
    (found,) = find_rings(ringing())
    assert found.frequency == pytest.approx(TRUE.frequency, rel=0.03)
    assert found.decay == pytest.approx(TRUE.decay, rel=0.35)
    assert found.size * (150.0 / found.typical) == pytest.approx(TRUE.size, rel=0.4)
    assert found.power == 1


def test_a_sway_is_a_slow_ring() -> None:
    found = find_rings(ringing(Ring(20.0, 0.05, 8.0, 150.0, 0)))
    assert found and all(ring.frequency < 1 / (39 * INTERVAL) for ring in found)


def test_two_rings_are_told_apart() -> None:
    other = Ring(1500.0, 4e-3, 6.0, 150.0, 1)
    o = ringing()
    parts = np.random.default_rng(1).standard_normal((len(o.names), 2))
    both = replace(o, force=o.force + np.einsum("ik,ikn->in", parts, other.columns(o.time, o.force.max(1))))
    found = sorted(ring.frequency for ring in find_rings(both))
    assert found == pytest.approx([TRUE.frequency, other.frequency], rel=0.05)


@pytest.mark.parametrize(("count", "most"), [(10, 1), pytest.param(40, 2, marks=pytest.mark.long)])
def test_noise_does_not_ring(count: int, most: int) -> None:
    """Two in a hundred may: the odds are twenty to one, over all that is tried."""
    random = np.random.default_rng(3)
    quiet = repeated(0.1)
    noise = quiet.noise.std * random.standard_normal((count, *quiet.force.shape))
    assert sum(bool(find_rings(replace(quiet, force=quiet.force.round(-3) + one))) for one in noise) <= most


def test_what_all_trials_share_is_signal() -> None:
    o = repeated(0.1)
    shared = TRUE.columns(o.time, o.force.max(1)).sum(1)
    assert find_rings(replace(o, force=o.force + shared)) == ()


def test_one_faulty_trial_is_no_ring() -> None:
    o = repeated(0.1)
    force = o.force.copy()
    force[4] *= 0.5
    assert find_rings(replace(o, force=force)) == ()


def test_without_repeats_nothing_is_known_of_rings() -> None:
    assert find_rings(ringing(conditions=12, repeats=1)) == ()
    assert find_rings(ringing(conditions=1, repeats=6)) == ()


def test_triggers_are_told_beside_a_ring() -> None:
    """A ring had hidden that triggers are exact: then their scatter counted as large as it can be."""
    o = ringing()
    assert trigger_scatter(o) > 0.3
    assert with_scatter(o, fit_nominal(o)).trigger_std < 0.1


def test_a_mass_that_rings_with_the_trigger_is_no_ring_of_its_own() -> None:
    """At 3.2 kHz, of samples at 5 kHz, triggers half a sample apart turn its phase by more than a radian."""
    o, random = repeated(0.0), np.random.default_rng(7)
    mass = 0.076, 3e7, 1e-5
    grid = Grid(2e-5, 500)
    forces = forward(("fixture_mass",), np.array([*RIG.values, *mass]), o.v_e, o.f_p, grid)
    late = INTERVAL * random.uniform(-0.4, 0.4, len(o.names))
    readings = [
        at_times(f, t - by, grid.h, c)
        for f, t, by, c in zip(forces.sensed, o.time, late, forces.contact, strict=True)
    ]
    o = replace(o, force=np.array(readings) + o.noise.std * random.standard_normal(o.force.shape))
    assert find_rings(o)
    fitted = fit(o, ("fixture_mass",), begin(RIG.values, mass))
    assert fitted.objective < 0.6 * o.n_used and find_rings(o, fitted) == ()


def test_a_ring_that_a_fit_has_as_nuisance_is_found_again() -> None:
    o = ringing()
    beside = with_scatter(o, fit_nominal(o))
    again = find_rings(beside, fit_nominal(beside))
    assert [r.frequency for r in again] == pytest.approx([r.frequency for r in beside.rings], rel=0.03)
    assert len(again) >= 1


def test_a_ring_is_a_nuisance_of_each_trace_and_of_no_peak() -> None:
    o = ringing()
    o = with_scatter(o, fit_nominal(o))
    is_peak = np.arange(len(o.names)) == 0
    o = replace(o, peak_only=is_peak)
    assert o.n_nuisances == 5 and o.ringing.shape == (len(o.names), 2, o.force.shape[1])
    assert not o.ringing[0].any() and o.ringing[1].any()
    assert replace(o, rings=()).ringing.shape == (len(o.names), 0, o.force.shape[1])
    assert o.subset(~is_peak).rings == o.rings

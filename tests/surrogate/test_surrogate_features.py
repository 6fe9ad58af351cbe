"""Features: what they are invariant to, their limits, and force as the inverse of the target."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from acf_jax.model import Impact, Rig, find_peaks
from acf_jax.surrogate.features import FEATURES
from acf_jax.surrogate.fold import distance_to_fold


def wide_box(count: int, seed: int = 0) -> tuple[Rig, Impact]:
    """Random samples of the wide box."""
    random = np.random.default_rng(seed)
    m, k_c = 0.5 * 20 ** random.random(count), 1e4 * 100 ** random.random(count)
    k_f, zeta = 1e4 * random.random(count), 1.5 * random.random(count)
    rig = Rig(m=m, d=2 * zeta * np.sqrt(m * (k_f + k_c)), k_f=k_f, k_c=k_c)
    return rig, Impact(v_e=0.01 * 100 ** random.random(count), f_p=500 * random.random(count))


@pytest.mark.parametrize("name", FEATURES)
def test_force_inverts_target(name: str) -> None:
    rig, impact = wide_box(5000)
    peak = find_peaks(rig, impact)
    y = jax.vmap(FEATURES[name].target)(rig, impact, peak)
    force = jax.vmap(FEATURES[name].force)(rig, impact, y)
    kept = np.asarray(peak.has_peak)
    np.testing.assert_allclose(force[kept], peak.f_max[kept], rtol=1e-12)
    x = jax.vmap(FEATURES[name].coordinates)(rig, impact)
    assert x.shape == (5000, len(FEATURES[name].inputs))
    assert bool(jnp.isfinite(x).all())


@pytest.mark.parametrize("name", ["dimensionless", "fold"])
def test_dimensionless_under_a_change_of_units(name: str) -> None:
    """Mass, length and time in other units change the force by their units and the features not at all."""
    mass, length, time = 3.0, 0.2, 7.0
    rig, impact = wide_box(2000)
    other_rig = Rig(
        m=rig.m * mass, d=rig.d * mass / time, k_f=rig.k_f * mass / time**2, k_c=rig.k_c * mass / time**2
    )
    other_impact = Impact(v_e=impact.v_e * length / time, f_p=impact.f_p * mass * length / time**2)
    features = FEATURES[name]
    here = jax.vmap(features.coordinates)(rig, impact)
    there = jax.vmap(features.coordinates)(other_rig, other_impact)
    # u = sqrt(1 - r/r_m) amplifies rounding near the fold
    np.testing.assert_allclose(there, here, rtol=1e-9, atol=1e-7)
    y = jnp.full(2000, 0.3)
    ratio = jax.vmap(features.force)(other_rig, other_impact, y) / jax.vmap(features.force)(rig, impact, y)
    np.testing.assert_allclose(ratio, mass * length / time**2, rtol=1e-9)


def test_fold_agrees_with_the_model_on_which_impacts_have_a_peak() -> None:
    rig, impact = wide_box(200_000, seed=5)
    fold, peak = jax.jit(jax.vmap(distance_to_fold))(rig, impact), find_peaks(rig, impact)
    assert np.array_equal(fold.has_peak, peak.has_peak)
    tau = np.asarray(rig.omega * peak.t_max)
    kept = np.asarray(peak.has_peak)
    place = ((tau - fold.tau_0) / fold.sigma_m)[kept]
    assert place.min() > -1e-9 and place.max() < 1 + 1e-9


def test_limits_of_the_fold() -> None:
    """u = 1 and tau_0 is the peak for k_F = 0; u = 0 and sigma_m is the peak at the fold."""
    free = distance_to_fold(Rig(m=2, d=50, k_f=0, k_c=1e5), Impact(v_e=0.2, f_p=80))
    assert float(free.u) == 1
    peak = find_peaks(
        *jax.tree.map(jnp.atleast_1d, (Rig(m=2, d=50, k_f=0, k_c=1e5), Impact(v_e=0.2, f_p=80)))
    )
    assert float(peak.t_max[0]) * float(np.sqrt(1e5 / 2)) == pytest.approx(float(free.tau_0), rel=1e-12)

    def at(d: float) -> tuple[Rig, Impact]:
        return Rig(m=2.0, d=d, k_f=9e3, k_c=1e4), Impact(v_e=0.5, f_p=0.0)

    low, high = 0.0, 200.0
    for _ in range(60):  # bisect for the damping at which the peak disappears
        middle = (low + high) / 2
        low, high = (middle, high) if bool(distance_to_fold(*at(middle)).has_peak) else (low, middle)
    fold = distance_to_fold(*at(low))
    assert 0 <= float(fold.u) < 1e-6
    assert not bool(distance_to_fold(*at(high)).has_peak)
    target = FEATURES["fold"].target(*at(low), find_peaks(*jax.tree.map(jnp.atleast_1d, at(low))))
    assert float(target[0]) == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize("v_e,f_p", [(0.0, 100.0), (0.2, 0.0), (0.0, 0.0)])
def test_no_division_by_a_vanishing_group(v_e: float, f_p: float) -> None:
    rig, impact = Rig(m=2, d=0, k_f=1e3, k_c=1e5), Impact(v_e=v_e, f_p=f_p)
    fold = distance_to_fold(rig, impact)
    assert all(bool(jnp.isfinite(leaf)) for leaf in fold)
    gradient = jax.grad(lambda r: distance_to_fold(r, impact).u)(rig)
    assert all(bool(jnp.isfinite(leaf)) for leaf in jax.tree.leaves(gradient))

"""The surrogate's proved bound: a search that tries hard to break it, with good networks and with wrong ones."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from acf_jax.model import Impact, Rig, find_peaks
from acf_jax.safety.certificate import Certified, certified_peak
from acf_jax.surrogate import Surrogate, load_surrogate
from acf_jax.surrogate.features import DimensionlessFeatures
from tests import truth
from tests.surrogate.test_surrogate_features import wide_box

SAMPLES = 2**16


@pytest.fixture(scope="module")
def shipped() -> Surrogate:
    return load_surrogate()


@eqx.filter_jit
def bounds(surrogate: Surrogate, rig: Rig, impact: Impact) -> Certified:
    certified: Certified = jax.vmap(certified_peak, (None, 0, 0))(surrogate, rig, impact)
    return certified


def misled(surrogate: Surrogate, by: float) -> Surrogate:
    """The surrogate whose network is wrong by `by` widths of the bracket."""
    return eqx.tree_at(lambda s: s.y.centre, surrogate, surrogate.y.centre + by)


@pytest.mark.parametrize("by", [0.0, 1e-9, -1e-6, 1e-3, -1e-3, 0.1, -0.1, 1.0, -1.0])
def test_bound_holds_over_the_wide_box_whatever_the_network_says(shipped: Surrogate, by: float) -> None:
    rig, impact = wide_box(SAMPLES, seed=23)
    peak = find_peaks(rig, impact)
    found = bounds(misled(shipped, by), rig, impact)
    has_peak = np.asarray(peak.has_peak)
    assert np.array_equal(found.holds, has_peak)
    lower, force, upper = (np.asarray(x)[has_peak] for x in (found.lower, peak.f_max, found.upper))
    assert (lower <= force).all() and (force <= upper).all()
    if by == 0.0:
        assert np.quantile(upper / force - 1, 0.99) < 1e-6


def test_bound_holds_near_the_fold_where_the_search_drives_it(shipped: Surrogate) -> None:
    """Random directions are climbed towards the smallest slack, (upper - F)/F, which must stay positive."""
    rig, impact = wide_box(1024, seed=29)
    peak = find_peaks(rig, impact)
    keep = np.flatnonzero(np.asarray(peak.has_peak))[:512]
    z = np.log(
        np.stack(
            [np.asarray(x)[keep] + 1e-9 for x in (rig.m, rig.d, rig.k_f, rig.k_c, impact.v_e, impact.f_p)]
        )
    )
    random = np.random.default_rng(3)

    def slack(z: np.ndarray) -> np.ndarray:
        m, d, k_f, k_c, v, f = np.exp(z)
        one, other = Rig(m, d, k_f, k_c), Impact(v, f)
        exact, found = find_peaks(one, other), bounds(shipped, one, other)
        sound = np.asarray(exact.has_peak & found.holds)
        relative = np.asarray((found.upper - exact.f_max) / exact.f_max)
        below = np.asarray((exact.f_max - found.lower) / exact.f_max)
        return np.where(sound, np.minimum(relative, below), np.inf)

    best = slack(z)
    for step in np.geomspace(0.5, 1e-3, 60):
        trial = z + step * random.standard_normal(z.shape)
        value = slack(trial)
        better = value < best
        z[:, better], best = trial[:, better], np.where(better, value, best)
    assert np.isfinite(best).all() and (best > 0).all()


def test_bound_holds_against_sixty_digits(shipped: Surrogate) -> None:
    rig, impact = wide_box(64, seed=31)
    found = bounds(shipped, rig, impact)
    columns = (rig.m, rig.d, rig.k_f, rig.k_c, impact.v_e, impact.f_p)
    checked = 0
    for i, sample in enumerate(zip(*(map(float, x) for x in columns), strict=True)):
        exact = truth.peak(sample)
        assert (exact is not None) == bool(found.holds[i])
        if exact is not None:
            assert float(found.lower[i]) <= exact.f_max <= float(found.upper[i])
            checked += 1
    assert checked > 32


def test_only_a_surrogate_of_times_can_be_certified(shipped: Surrogate) -> None:
    other = dataclasses.replace(shipped, features=DimensionlessFeatures())
    one = jnp.asarray(1.0)
    with pytest.raises(ValueError, match="train with features: fold"):
        certified_peak(other, Rig(one, one, one, one), Impact(one, one))

"""The largest force until a time, against the equations on a fine grid, and the bound that no rebound exceeds."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from acf_jax.model import Impact, Rig, contact_force, find_peak
from acf_jax.model.until import force_bound, free_body_bound, largest_force_until

POINTS = 20_001
SOFT = Rig(m=0.5357, d=0.714, k_f=9487.0, k_c=1 / (1 / 126122.0 + 1 / 50e3)), Impact(0.98, 8.2)


def contacts(n: int) -> list[np.ndarray]:
    """m, zeta, k_F, k_C, v_E, F_P and t: every regime of damping, k_F = 0 and F_P = 0 among them."""
    random = np.random.default_rng(3)
    low, high = np.log([0.5, 1e-3, 10.0, 1e4, 0.01, 1.0, 1e-3]), np.log([10, 1.5, 1e4, 1e6, 1.0, 500, 0.5])
    columns = list(np.exp(low + random.random((n, 7)) * (high - low)).T)
    columns[1][: n // 8] = 0.0
    columns[2][n // 8 : n // 4] = 0.0
    columns[5][n // 4 : n // 2 : 2] = 0.0
    return columns


@pytest.fixture(scope="module")
def compared() -> tuple[np.ndarray, ...]:
    """Closed form, largest sample, bound and omega h of many contacts."""

    def one(sample: tuple[jax.Array, ...]) -> tuple[jax.Array, ...]:
        m, zeta, k_f, k_c, v, f_p, t = sample
        rig, impact = Rig(m, 2 * zeta * jnp.sqrt(m * (k_f + k_c)), k_f, k_c), Impact(v, f_p)
        forces = jax.vmap(lambda x: contact_force(rig, impact, x * t))(jnp.linspace(0.0, 1.0, POINTS))
        found = largest_force_until(rig, impact, t)
        return found, forces.max(), force_bound(rig, impact, t), rig.omega * t / (POINTS - 1)

    return tuple(
        map(np.asarray, jax.jit(lambda s: jax.lax.map(one, s))(tuple(map(jnp.asarray, contacts(800)))))
    )


def test_no_sample_is_above_the_closed_form_which_lies_at_most_a_parabola_above(compared) -> None:
    found, sampled, _, step = compared
    assert (sampled <= found * (1 + 1e-13)).all()
    assert (found <= sampled * (1 + step**2 / 2 + 1e-13)).all() and np.isfinite(found).all()


def test_the_bound_is_above(compared) -> None:
    found, _, bound, _ = compared
    assert (bound >= found * (1 - 1e-12)).all() and np.median(bound / found) < 3


def test_the_force_rises_far_above_its_first_peak() -> None:
    """Values of an integration with scipy's DOP853 at 1e-12."""
    peak = find_peak(*SOFT)
    told = [float(largest_force_until(*SOFT, jnp.asarray(t))) for t in (0.01, 0.02, 0.03, 0.04, 0.05)]
    assert told[0] == told[1] == pytest.approx(float(peak.f_max), rel=1e-14)
    assert told == pytest.approx([138.85, 138.85, 296.36, 296.36, 453.89], abs=0.01)
    assert float(largest_force_until(*SOFT, 0.9 * peak.t_max)) < float(peak.f_max)


def test_what_lasts_for_ever_is_told() -> None:
    assert np.isinf(float(largest_force_until(*SOFT, jnp.inf)))
    assert np.isinf(float(force_bound(*SOFT, jnp.inf)))
    rig, impact = Rig(2.0, 30.0, 0.0, 5e4), Impact(0.3, 20.0)
    assert float(largest_force_until(rig, impact, jnp.inf)) == pytest.approx(
        float(find_peak(rig, impact).f_max), rel=1e-14
    )
    at_rest = Impact(0.0, 20.0)
    assert float(largest_force_until(SOFT[0], at_rest, jnp.inf)) == pytest.approx(20.0, rel=1e-12)


def test_derivatives_are_those_of_finite_differences() -> None:
    rig, _ = SOFT
    for t in (0.004, 0.012, 0.03):
        slope = jax.grad(lambda v, t=t: largest_force_until(rig, Impact(v, 8.2), jnp.asarray(t)))(0.98)
        h = 1e-6
        up, down = (largest_force_until(rig, Impact(0.98 + x, 8.2), jnp.asarray(t)) for x in (h, -h))
        assert float(slope) == pytest.approx(float(up - down) / (2 * h), rel=1e-6)


def test_what_a_free_body_brings() -> None:
    rig, impact = SOFT
    assert float(free_body_bound(rig, impact, 0.6)) == pytest.approx(
        np.sqrt(8.2**2 + float(rig.k_c) * 0.6 * 0.98**2)
    )

"""The response in closed form against an integrator, its own derivatives, and its contracts."""

import jax
import jax.numpy as jnp
import mpmath as mp
import numpy as np
import pytest
from beartype import beartype
from jaxtyping import TypeCheckError, jaxtyped
from scipy.integrate import solve_ivp

from acf_jax.model import (
    Impact,
    Rig,
    contact_force,
    contact_force_curvature,
    contact_force_rate,
    find_peak,
    position,
    velocity,
)
from acf_jax.model.carlson import carlson_rc
from acf_jax.model.stumpff import damped_stumpff
from tests import truth

RIGS = {
    "undamped": Rig(4.0, 0.0, 3000.0, 1e5),
    "underdamped": Rig(4.0, 200.0, 3000.0, 1e5),
    "critical": Rig(1.0, 200.0, 0.0, 1e4),
    "overdamped": Rig(1.0, 900.0, 2000.0, 1e4),
}
IMPACT = Impact(0.3, 100.0)


@pytest.mark.parametrize("rig", RIGS.values(), ids=RIGS.keys())
def test_matches_an_integrator(rig):
    m, d, k_f, k_c, v, f_p = map(float, (rig.m, rig.d, rig.k_f, rig.k_c, IMPACT.v_e, IMPACT.f_p))
    times = np.linspace(0, 0.3, 61)

    def motion(t, y):  # Eqs. (1) and (2)
        x, x_dot = y
        return x_dot, (k_c * (v * t - x) + f_p - d * x_dot - k_f * x) / m

    solution = solve_ivp(motion, (0, 0.3), (0, 0), "DOP853", times, rtol=1e-12, atol=1e-14, max_step=1e-3)
    x = jax.vmap(lambda t: position(rig, IMPACT, t))(times)
    x_dot = jax.vmap(lambda t: velocity(rig, IMPACT, t))(times)
    force = jax.vmap(lambda t: contact_force(rig, IMPACT, t))(times)
    np.testing.assert_allclose(x, solution.y[0], atol=1e-11)
    np.testing.assert_allclose(x_dot, solution.y[1], atol=1e-9)
    np.testing.assert_allclose(force, k_c * (v * times - solution.y[0]) + f_p, atol=1e-5)


@pytest.mark.parametrize("rig", RIGS.values(), ids=RIGS.keys())
def test_functions_are_each_others_derivatives(rig):
    for t in (0.0, 1e-4, 0.02, 0.3):
        chain = (
            (position, velocity),
            (contact_force, contact_force_rate),
            (contact_force_rate, contact_force_curvature),
        )
        for of, slope in chain:
            expected = jax.grad(lambda s, of=of: of(rig, IMPACT, s))(t)
            np.testing.assert_allclose(slope(rig, IMPACT, t), expected, rtol=1e-9, atol=1e-9)


def test_starts_at_rest_with_the_pretension():
    for rig in RIGS.values():
        np.testing.assert_allclose(position(rig, IMPACT, 0.0), 0.0, atol=1e-17)
        assert velocity(rig, IMPACT, 0.0) == 0
        np.testing.assert_allclose(contact_force(rig, IMPACT, 0.0), 100.0, rtol=1e-14)


def test_long_times_do_not_overflow():
    rig = Rig(0.5, 5000.0, 10.0, 1e4)
    value, gradient = jax.value_and_grad(lambda r: contact_force(r, IMPACT, 100.0))(rig)
    sample = (0.5, 5000.0, 10.0, 1e4, 0.3, 100.0)
    np.testing.assert_allclose(value, float(truth.force(sample, mp.mpf(100))), rtol=1e-12)
    assert all(np.isfinite(g) for g in jax.tree.leaves(gradient))


@pytest.mark.parametrize("k", range(6))
def test_damped_stumpff(k):
    for z in (-1e4, -60.0, -8.1, -7.9, -1.0, -1e-8, 0.0, 1e-8, 1.0, 7.9, 8.1, 60.0, 1e4):
        alpha = float(np.sqrt(max(-z, 0))) + 0.5

        def exact(alpha, z, k=k):
            return mp.exp(-alpha) * mp.nsum(lambda j: (-z) ** j / mp.factorial(2 * j + k), [0, mp.inf])

        with mp.workdps(140):
            value = float(exact(mp.mpf(alpha), mp.mpf(z))) if abs(z) < 100 else None
        if value is not None:
            got = damped_stumpff(k, jnp.array(alpha), jnp.array(z))
            np.testing.assert_allclose(got, value, rtol=1e-12, atol=1e-15)
        derivatives = jax.grad(lambda a, z, k=k: damped_stumpff(k, a, z), argnums=(0, 1))(alpha, z)
        assert np.isfinite(derivatives).all()


def test_carlson_rc_is_atan_and_atanh():
    for g, h in ((0.0, 1.0), (0.3, 1.0), (1.0, 1.0), (1.5, 1.0), (2.0, 0.3), (1.0, 0.01)):
        exact = float(mp.elliprc(mp.mpf(g) ** 2, mp.mpf(h) ** 2))
        np.testing.assert_allclose(carlson_rc(jnp.array(g), jnp.array(h)), exact, rtol=1e-14)


def test_carlson_rc_is_right_to_a_few_units_in_the_last_place():
    for size in (*np.linspace(0, 2, 101), *np.geomspace(2, 1e3, 101)):
        exact = float(mp.elliprc(mp.mpf(float(size)) ** 2, 1))
        np.testing.assert_allclose(carlson_rc(jnp.array(size), jnp.array(1.0)), exact, rtol=9e-16)


@pytest.mark.parametrize("function", [position, velocity, contact_force, contact_force_rate])
def test_one_sample_at_a_time(function):
    checked = jaxtyped(function, typechecker=beartype)
    rig, impact, t = Rig(4.0, 10.0, 0.0, 1e5), IMPACT, jnp.array(0.01)
    assert checked(rig, impact, t).shape == ()
    with pytest.raises(TypeCheckError):
        checked(rig, impact, jnp.linspace(0, 1, 3))


def test_invalid_values_are_refused_together():
    with pytest.raises(ValueError, match=r"Rig.m .*positive.*-1.*Rig.d .*zero or positive.*nan.*SI units"):
        Rig(m=-1.0, d=float("nan"), k_f=0.0, k_c=1e5)
    with pytest.raises(ValueError, match=r"Impact.f_p .* is -3"):
        Impact(v_e=jnp.ones(3), f_p=jnp.array([1.0, -3.0, 2.0]))
    assert jax.jit(lambda m: find_peak(Rig(m, 0.0, 0.0, 1e5), IMPACT).f_max)(4.0) > 0


def test_values_keep_their_precision():
    rig = Rig(*np.array([4, 10, 0, 1e5], np.float32))
    impact = Impact(np.float32(0.3), np.float32(100))
    assert contact_force(rig, impact, jnp.float32(0.01)).dtype == np.float32
    assert find_peak(rig, impact).f_max.dtype == np.float32

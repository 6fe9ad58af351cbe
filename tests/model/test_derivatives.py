"""First and second derivatives of the peak against differences of 60-digit truth."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from acf_jax.model import Impact, Rig, find_peak, find_peaks
from tests import truth
from tests.model.test_peak import at_the_fold, batch


def peak_of(parameters: jax.Array) -> tuple[jax.Array, jax.Array]:
    peak = find_peak(Rig(*parameters[:4]), Impact(*parameters[4:]))
    return peak.f_max, peak.t_max


peak_at = jax.jit(peak_of)
by_reverse = jax.jit(jax.jacrev(peak_of))
by_forward = jax.jit(jax.jacfwd(peak_of))
by_both = jax.jit(jax.hessian(peak_of))


def scales_of(sample: tuple[float, ...]) -> tuple[float, ...]:
    """Natural sizes of the six parameters, also where a parameter is zero."""
    m, _, k_f, k_c, v, f_p = sample
    k = k_f + k_c
    return (m, 2 * np.sqrt(m * k), k, k, v, f_p + v * np.sqrt(m * k))


FOLD = (2.0, 2 * 0.4 * np.sqrt(2.0 * 1e5), 0.0, 1e5, 0.8, 160.0)
SAMPLES = {
    "underdamped": (4.0, 200.0, 3000.0, 2e5, 0.2, 100.0),
    "critical": (1.0, 200.0, 0.0, 1e4, 0.1, 300.0),
    "overdamped": (2.0, 1200.0, 500.0, 1e5, 0.05, 400.0),
    "undamped, no actuator": (4.0, 0.0, 0.0, 2e5, 0.2, 100.0),
    "no pretension": (4.0, 50.0, 3000.0, 2e5, 0.2, 0.0),
    "slow": (4.0, 50.0, 3000.0, 2e5, 1e-5, 100.0),
    "next to the fold": (*FOLD[:2], None, *FOLD[3:]),
}


@pytest.mark.parametrize("sample", SAMPLES.values(), ids=SAMPLES.keys())
def test_derivatives_match_truth(sample):
    tight = 1e-10
    if sample[2] is None:
        sample, tight = (*sample[:2], at_the_fold(FOLD) * (1 - 1e-4), *sample[3:]), 1e-8
    parameters, scales = jnp.array(sample), np.array(scales_of(sample))
    values, (gradients, hessians) = truth.peak(sample), truth.derivatives(sample, tuple(scales))
    every = (gradients, hessians, by_reverse(parameters), by_forward(parameters), by_both(parameters))
    for value, gradient, hessian, reverse, forward, both in zip(map(float, values), *every, strict=True):
        # logarithmic derivatives, so that one tolerance fits newtons per kilogram and per metre
        first, second = scales / value, np.outer(scales, scales) / value
        within = tight * np.abs(gradient * first).max() + 1e-14
        np.testing.assert_allclose(reverse * first, gradient * first, rtol=0, atol=within)
        np.testing.assert_allclose(forward * first, gradient * first, rtol=0, atol=within)
        within = 10 * tight * np.abs(hessian * second).max() + 1e-14
        np.testing.assert_allclose(both * second, hessian * second, rtol=0, atol=within)


@pytest.mark.long
def test_everything_is_finite_over_the_box_and_its_edges():
    samples = truth.wide_box(2000, seed=6)
    samples[:200, 1] = 0.0
    samples[100:300, 2] = 0.0
    samples[200:400, 5] = 0.0
    samples[400:450, 4] = 0.0
    samples[440:460, 5] = 0.0
    samples[460:500, 1] = 2 * np.sqrt(samples[460:500, 0] * (samples[460:500, 2] + samples[460:500, 3]))
    first = jax.jit(jax.vmap(by_reverse))(jnp.array(samples))
    second = jax.jit(jax.vmap(by_both))(jnp.array(samples[:600]))
    for derivative in jax.tree.leaves((first, second)):
        assert jnp.isfinite(derivative).all()


def test_float32_derivatives_keep_their_precision():
    samples = truth.wide_box(40, seed=7)
    with_peak = np.array([truth.peak(tuple(s)) is not None for s in samples])
    gradients = [jax.vmap(by_reverse)(jnp.array(samples, dtype))[0] for dtype in (np.float32, np.float64)]
    assert gradients[0].dtype == np.float32
    scales = np.array([scales_of(tuple(s)) for s in samples])
    error = np.abs(gradients[0] - gradients[1]) * scales
    size = np.abs(gradients[1] * scales).max(axis=1, keepdims=True)
    assert (error / size)[with_peak].max() < 2e-4


@pytest.mark.long
def test_batch_gradients_equal_those_of_samples():
    rig, impact = batch(truth.wide_box(9000, seed=8))
    of_batch = jax.grad(lambda r, i: find_peaks(r, i).f_max.sum(), argnums=(0, 1))(rig, impact)
    of_samples = jax.jit(jax.vmap(jax.grad(lambda r, i: find_peak(r, i).f_max, argnums=(0, 1))))(rig, impact)
    for x, y in zip(jax.tree.leaves(of_batch), jax.tree.leaves(of_samples), strict=True):
        np.testing.assert_allclose(x, y, rtol=1e-9, atol=1e-12 * np.abs(y).max())


def test_a_stopped_time_would_give_another_hessian():
    """The envelope theorem serves first derivatives only: the guard that the second ones see t move."""
    from acf_jax.model import contact_force

    sample = jnp.array(SAMPLES["underdamped"])
    t_max = peak_at(sample)[1]
    stopped = jax.jit(jax.hessian(lambda p: contact_force(Rig(*p[:4]), Impact(*p[4:]), t_max)))(sample)
    assert not np.allclose(by_both(sample)[0], stopped, rtol=1e-2)

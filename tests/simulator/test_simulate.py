"""The integrator: closed form, order, end stop, loss of contact, derivatives, batches."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from acf_jax.effects.end_stop import EndStop
from acf_jax.effects.pretension_error import PretensionError
from acf_jax.effects.sensor_lag import SensorLag
from acf_jax.effects.sensor_resonance import SensorResonance
from acf_jax.model import Impact, Rig, contact_force, find_peak
from acf_jax.simulator import largest_force, simulate
from acf_jax.simulator.derivatives import simulate_with_derivatives
from acf_jax.simulator.simulate import make_system
from tests.effects.contract import IMPACT, LONG, QUICK, RIG, SAMPLES, H, run

OMEGA_H = 0.01


@functools.partial(jax.jit, static_argnames="samples")
def paper(rig, impact, h, samples=SAMPLES, steps=None, pull=0.0):
    return simulate(rig, impact, [], h, samples, steps, pull).contact


@pytest.mark.parametrize("zeta", [0.0, 0.1, 1.0, 1.4])
def test_without_effects_it_is_the_closed_form(zeta):
    k = 1.21e5
    rig = Rig(m=3.0, d=2 * zeta * (3.0 * k) ** 0.5, k_f=1e3, k_c=k - 1e3)
    h = OMEGA_H / float(rig.omega)
    for pull in (0.0, 1.0):
        force = np.asarray(paper(rig, IMPACT, h, 800, pull=pull))
        exact = np.asarray(jax.vmap(lambda t: contact_force(rig, IMPACT, t))(h * jnp.arange(800)))
        lost = len(exact) if pull else np.argmax(np.append(exact, -1.0) <= 0)
        assert np.allclose(force[:lost], exact[:lost], rtol=0, atol=1e-6)
    peak = find_peak(rig, IMPACT)
    if peak.has_peak:
        assert np.isclose(force[round(float(peak.t_max) / h)], float(peak.f_max), rtol=1e-4)


def test_it_is_of_fourth_order():
    duration, steps = 0.01, np.array([16, 32, 64, 128])
    exact = float(contact_force(RIG, IMPACT, jnp.asarray(duration)))
    error = [abs(float(paper(RIG, IMPACT, duration / n, steps=n)[n]) - exact) for n in steps]
    order = -np.polyfit(np.log(steps), np.log(error), 1)[0]
    assert 3.8 < order < 4.3


def test_every_effect_sees_the_pretension_that_acts():
    """A label of 100 N that is 25 N too high is a pretension of 75 N, for the contact and for an end stop."""
    never = 1e9  # s, until what is missing comes

    @jax.jit
    def force(label, stopped, share, offset):
        effects = [EndStop(stopped, stopped), PretensionError(share, offset, never)]
        return simulate(RIG, Impact(0.2, label), effects, H, SAMPLES).contact

    for stopped in (0.0, 0.6):
        right = force(75.0, stopped, 0.0, 0.0)
        for share, offset in ((-0.25, 0.0), (0.0, -25.0), (-0.5, 25.0)):
            assert np.allclose(force(100.0, stopped, share, offset), right, rtol=0, atol=1e-6)
    assert np.allclose(force(20.0, 0.0, 0.0, -30.0), force(0.0, 0.0, 0.0, 0.0), rtol=0, atol=1e-9)


def test_a_held_flange_is_released_when_the_contact_force_exceeds_the_pretension():
    """Until sigma F_P/(k_C v) the force is the ramp k_C v t + (1 - sigma) F_P, then the mass gives way."""
    k_c, v_e, f_p = float(RIG.k_c), float(IMPACT.v_e), float(IMPACT.f_p)
    for sigma in (0.3, 0.77, 1.0):
        force = run(EndStop, [[sigma, sigma]]).contact[0]
        t = H * np.arange(SAMPLES)
        ramp, released = k_c * v_e * t + (1 - sigma) * f_p, sigma * f_p / (k_c * v_e)
        held = t <= released
        assert np.allclose(force[held], ramp[held], rtol=0, atol=1e-9)
        # the mass starts from rest under (1 - sigma) F_P: the force leaves the ramp by k_C (1 - sigma) F_P t^2/(2 m)
        late = np.argmax(~held) + 10
        since = t[late] - released
        mass = float(RIG.m)
        fall = k_c * ((1 - sigma) * f_p * since**2 / 2 + k_c * v_e * since**3 / 6) / mass
        assert np.isclose(ramp[late] - force[late], fall, rtol=2e-2)


@pytest.mark.parametrize("h", [5e-5, 7.3e-5])
def test_peak_with_a_full_end_stop(h):
    """F_P + v sqrt(k_C m) without damping, whatever part of a step the release falls into."""
    rig = Rig(m=3.0, d=0.0, k_f=0.0, k_c=1.2e5)
    force = simulate(rig, IMPACT, [EndStop(1.0, 1.0)], h, 321).contact
    k = int(jnp.argmax(force))
    top = np.polynomial.Polynomial.fit([-1, 0, 1], force[k - 1 : k + 2], 2)
    peak = float(top(top.deriv().roots()[0].real))
    assert np.isclose(peak, 80.0 + 0.21 * (1.2e5 * 3.0) ** 0.5, rtol=0, atol=1e-3)


def test_a_lost_contact_does_not_pull():
    force = np.asarray(paper(RIG, IMPACT, LONG))
    continued = np.asarray(paper(RIG, IMPACT, LONG, pull=1.0))
    lost = np.argmax(force <= 0)
    assert 0 < lost < SAMPLES
    assert (force >= 0).all() and (force[lost : lost + 20] == 0).all()
    assert np.allclose(force[:lost], continued[:lost], rtol=0, atol=1e-9)
    assert continued[lost] < 0


def test_reverse_mode_equals_forward_mode():
    """With a static number of steps; held flange and sensor are in the program."""

    def weighed(theta):
        effects = [EndStop(theta[0], theta[1]), SensorLag(theta[2], theta[3])]
        rig, impact = Rig(*theta[4:8]), Impact(theta[8], theta[9])
        response = simulate(rig, impact, effects, 2e-4, 60)
        return jnp.mean(response.sensed) + jnp.mean(response.contact**2) / 100

    theta = jnp.array([0.4, 0.6, 3e-4, 0.9, 3.0, 30.0, 1e3, 1.2e5, 0.21, 80.0])
    backward, forward = (
        jax.jit(mode(weighed), compiler_options=QUICK)(theta) for mode in (jax.grad, jax.jacfwd)
    )
    assert np.isfinite(backward).all()
    assert np.allclose(backward, forward, rtol=1e-9, atol=0)


def test_free_flange_has_finite_reverse_mode():
    slope = jax.jit(jax.grad(lambda m: simulate(Rig(m, 30.0, 1e3, 1.2e5), IMPACT, [], H, 60).contact[-1]))
    exact = jax.grad(lambda m: contact_force(Rig(m, 30.0, 1e3, 1.2e5), IMPACT, jnp.asarray(59 * H)))
    assert np.isclose(slope(3.0), exact(3.0), rtol=1e-6)


def test_derivatives_written_into_the_loop_are_those_of_jax():
    """A held flange, a sensor with memory, and contact that is lost."""

    def system(theta):
        return make_system(
            Rig(*theta[:4]), Impact(*theta[4:6]), [EndStop(*theta[6:8]), SensorLag(*theta[8:])]
        )

    def traces(theta):
        effects = [EndStop(*theta[6:8]), SensorLag(*theta[8:])]
        response = simulate(Rig(*theta[:4]), Impact(*theta[4:6]), effects, LONG, SAMPLES, 200)
        return response.sensed, response.contact

    first = jnp.array([3.0, 30.0, 1e3, 1.2e5, 0.21, 80.0, 0.4, 0.6, 3e-4, 0.9])
    both = jnp.stack([first, first.at[5].set(0.0)])
    contact, rows = jax.jit(
        lambda z: simulate_with_derivatives(system, z, jnp.asarray(LONG), SAMPLES, jnp.asarray(200))
    )(both)
    for k, theta in enumerate(both):
        sensed, expected = traces(theta)
        assert np.allclose(contact[:, k], expected, rtol=1e-12, atol=1e-9)
        assert np.allclose(rows[:, 0, k], sensed, rtol=1e-12, atol=1e-9)
        slopes = jax.jacfwd(lambda theta: traces(theta)[0])(theta)
        scale = np.abs(slopes).max(axis=0)
        assert (np.abs(rows[:, 1:, k] - slopes) <= 1e-9 * scale).all()
    assert (contact[1:200] == 0).any(axis=0).all()


def test_impacts_map_over_a_batch():
    impacts = Impact(v_e=jnp.array([0.1, 0.21, 0.3]), f_p=jnp.array([40.0, 80.0, 0.0]))
    together = jax.jit(jax.vmap(lambda impact: paper(RIG, impact, LONG)))(impacts)
    for i, force in enumerate(together):
        alone = paper(RIG, jax.tree.map(lambda leaf, i=i: leaf[i], impacts), LONG)
        assert np.allclose(force, alone, rtol=0, atol=1e-9)


def test_steps_beyond_the_last_stay_zero():
    force = np.asarray(paper(RIG, IMPACT, H, steps=10))
    assert (force[:11] > 0).all() and (force[11:] == 0).all()


@pytest.mark.parametrize("which", ["contact", "sensed"])
def test_the_largest_force_is_that_of_the_trace(which):
    """A ringing sensor and a held flange: force and time of the peak, and whether it is one within the window."""
    effects = [EndStop(0.6, 0.6), SensorResonance(share=0.5, frequency_hz=300.0, damping_ratio=0.05)]
    program = jax.jit(
        lambda window: largest_force(RIG, IMPACT, effects, H, window, which), compiler_options=QUICK
    )
    trace = jax.jit(lambda: simulate(RIG, IMPACT, effects, H, 6 * SAMPLES), compiler_options=QUICK)()
    lost = int(np.argmax(np.asarray(trace.contact) <= 0))
    assert lost > 0
    force = np.asarray(getattr(trace, which))[: lost + 1]
    top, found = int(force.argmax()), program(6 * SAMPLES * H)
    assert found.exists and 0 <= float(found.force) - force[top] < 1e-4 * force[top]
    assert abs(float(found.time) - top * H) <= H / 2
    assert not program(top * H / 2).exists, "a force that still rises at the end of the window has no peak"

"""The scipy world: its neutral case is the paper's closed form, and each cause does what its name says."""

from dataclasses import dataclass, replace

import mpmath
import numpy as np
import pytest

from acf_jax.errors import InputError
from acf_jax.worlds import Impact, Rig, distance, draw_setup, find_world
from acf_jax.worlds.distance import Tangents
from acf_jax.worlds.scipy_world.plant import Plant
from acf_jax.worlds.scipy_world.ports import Motion

WORLD = find_world("scipy")
RIG = Rig(m=2.0, d=90.0, k_f=2000.0, k_c=2.0e5)
IMPACT = Impact(v_e=0.25, f_p=80.0)
TIME = np.arange(-20, 400) / 8000.0
CAUSES = sorted(WORLD.causes())


def closed_form(rig, impact, t):
    """F_C by Eqs. (5) to (8), in 30 digits."""
    with mpmath.workdps(30):
        m, d, k_f, k_c, v, f_p = map(mpmath.mpf, (rig.m, rig.d, rig.k_f, rig.k_c, *impact))
        k, delta = k_f + k_c, d / (2 * m)
        nu = mpmath.sqrt(k / m - delta**2)
        constant = f_p / k - d * k_c * v / k**2
        a = -constant
        b = (delta * a - k_c * v / k) / nu
        swing = mpmath.exp(-delta * t) * (a * mpmath.cos(nu * t) + b * mpmath.sin(nu * t))
        return float(k_c * (v * t - (swing + constant + k_c * v * t / k)) + f_p)


@pytest.mark.parametrize("zeta", [0.0, 0.1, 0.7])
@pytest.mark.parametrize("impact", [Impact(0.05, 120.0), Impact(0.4, 0.0), IMPACT])
def test_without_causes_it_is_the_closed_form(zeta, impact):
    rig = Rig(m=2.0, d=2.0 * zeta * np.sqrt(2.0 * 2.02e5), k_f=2000.0, k_c=2.0e5)
    response = WORLD.respond(rig, [], impact, TIME)
    touching = response.time >= 0.0
    expected = [closed_form(rig, impact, t) for t in response.time[touching]]
    np.testing.assert_allclose(response.contact[touching], expected, rtol=0.0, atol=2e-3)
    assert not response.contact[~touching].any()
    if np.isfinite(response.lost):
        assert abs(closed_form(rig, impact, response.lost)) < 0.02


@pytest.fixture(scope="module")
def tangents():
    setup = draw_setup(np.random.default_rng(2), coloured=False)
    return Tangents(WORLD, replace(setup, conditions=setup.conditions[-3:]))


@pytest.mark.parametrize("name", CAUSES)
def test_a_small_cause_is_nearly_none_and_a_large_one_is_seen(name, tangents):
    setup = tangents.setup
    small, large = (
        distance(WORLD, setup, [WORLD.draw(name, 3, setup.rig, size)], tangents) for size in (1e-4, 1.0)
    )
    assert small < 2.0 < 6.0 < large


@pytest.mark.parametrize("name", CAUSES)
def test_equal_seeds_draw_equal_causes(name):
    assert WORLD.draw(name, 7, RIG, 0.5) == WORLD.draw(name, 7, RIG, 0.5)
    assert WORLD.draw(name, 7, RIG, 0.5) != WORLD.draw(name, 7, RIG, 0.25)


@pytest.mark.parametrize("name", CAUSES)
def test_contact_only_pushes_and_a_sensor_leaves_it_alone(name):
    cause = WORLD.draw(name, 5, RIG, 0.7)
    response = WORLD.respond(RIG, [cause], IMPACT, TIME, after_loss=0.002)
    assert response.contact.min() >= 0.0
    nominal = WORLD.respond(RIG, [], IMPACT, response.time, after_loss=np.inf)
    unchanged = np.allclose(response.contact, nominal.contact, atol=1e-3)
    assert unchanged == (cause.component == "sensor")
    assert np.array_equal(response.sensed, response.contact) == (cause.component != "sensor")


@dataclass(frozen=True)
class Expectation:
    """The sign of what a cause does to the largest contact force and to the loss of contact."""

    peak: int
    lost: int


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("coulomb_friction", Expectation(peak=1, lost=1)),
        ("force_regulation", Expectation(peak=1, lost=1)),
        ("end_stop", Expectation(peak=1, lost=1)),
        ("magnetic_detent", Expectation(peak=1, lost=1)),
        ("orifice_damping", Expectation(peak=1, lost=1)),
        ("contact_hardening", Expectation(peak=1, lost=-1)),
        ("cracking_pad", Expectation(peak=-1, lost=1)),
        ("loose_pad", Expectation(peak=-1, lost=1)),
        ("robot_compliance", Expectation(peak=-1, lost=-1)),
        ("robot_deceleration", Expectation(peak=-1, lost=-1)),
        ("robot_admittance", Expectation(peak=-1, lost=-1)),
    ],
)
def test_peak_and_duration_move_the_right_way(name, expected):
    nominal = WORLD.respond(RIG, [], IMPACT, TIME)
    moved = WORLD.respond(RIG, [WORLD.draw(name, 1, RIG, 0.3)], IMPACT, TIME)
    assert np.sign(moved.contact.max() - nominal.contact.max()) == expected.peak
    assert np.sign(moved.lost - nominal.lost) == expected.lost


def test_a_sensor_of_unit_gain_passes_a_constant_force():
    for name in ("sensor_lag", "sensor_resonance"):
        for seed in range(6):
            cause = WORLD.draw(name, seed, RIG, 0.5)
            reading = cause.read(np.arange(60000) * 1e-5, np.full(60000, 50.0))
            assert reading[0] == pytest.approx(0.0 if name == "sensor_lag" else 25.0)
            assert reading[-1] == pytest.approx(50.0, abs=1e-3)


def test_first_order_lag_is_the_exponential():
    lag = next(c for s in range(20) if (c := WORLD.draw("sensor_lag", s, RIG, 0.5)).order == 1)
    time = np.arange(400) * 1e-5
    ramp = lag.read(time, 10.0 + 1e4 * time)
    decay = np.exp(-time / lag.delay)
    expected = 10.0 * (1.0 - decay) + 1e4 * (time - lag.delay * (1.0 - decay))
    np.testing.assert_allclose(ramp, expected, atol=1e-9)


def test_kelvin_voigt_and_hertz_forces_by_hand():
    damping = next(c for s in range(20) if not (c := WORLD.draw("contact_damping", s, RIG, 0.5)).per_velocity)
    assert damping.contact(30.0, (), RIG, IMPACT, 1e-4, 0.1) == 30.0 + 0.1 * damping.viscous
    assert damping.contact(30.0, (), RIG, IMPACT, 1e-4, -100.0) == 0.0
    start = WORLD.respond(RIG, [damping], IMPACT, TIME).contact[20]
    assert start == pytest.approx(80.0 + damping.viscous * 0.25)
    hertz = next(c for s in range(20) if not (c := WORLD.draw("contact_hardening", s, RIG, 1.0)).gain)
    half, whole = (
        hertz.contact(RIG.k_c * s, (), RIG, IMPACT, s, 0.0) for s in np.array([0.5, 1.0]) * hertz.reference
    )
    assert whole / half == pytest.approx(2.0**1.5, rel=2e-3)


def test_the_contact_force_accelerates_pad_and_flange_together():
    rig = Rig(m=2.0, d=0.0, k_f=0.0, k_c=2.0e5)
    pad = WORLD.draw("pad_mass", 1, rig, 1.0)
    plant = Plant(rig, [pad], IMPACT)
    moved = plant.initial + np.array([3e-4, 0.1, 4e-4, 0.2, 0.0])
    rates = plant.rates(1e-3, moved)
    assert rig.m * rates[1] + pad.mass * rates[3] == pytest.approx(plant.contact_force(1e-3, moved))
    assert rates[1] > 0.0


def test_a_yielded_pad_does_not_come_back():
    pad = WORLD.draw("yielding_pad", 1, RIG, 1.0)
    plant = Plant(RIG, [pad], IMPACT)
    loaded, unloaded = (Motion(0.0, 0.0, 0.0, 1e-3, 0.0, pad.yield_force + sign * 50.0) for sign in (1, -1))
    assert pad.rates([0.0], RIG, IMPACT, loaded)[0] > 0.0 == pad.rates([1e-4], RIG, IMPACT, unloaded)[0]
    assert plant.contact_force(0.0, [0.0, 0.0, 1e-4]) < plant.contact_force(0.0, [0.0, 0.0, 0.0])


def test_unknown_names_are_refused_with_a_remedy():
    with pytest.raises(InputError, match="world 'nowhere' does not exist; there are"):
        find_world("nowhere")
    with pytest.raises(InputError, match="is not a cause of world 'scipy'; it has"):
        WORLD.draw("ghost", 1, RIG, 1.0)

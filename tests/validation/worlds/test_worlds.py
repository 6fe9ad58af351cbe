"""Every world: without causes it is the paper's closed form, and each cause does what its name says."""

import importlib.util
from dataclasses import dataclass, replace
from itertools import combinations

import mpmath
import numpy as np
import pytest

from acf_jax.errors import InputError
from tests.needs import need_module
from validation.worlds import Impact, Rig, distance, draw_setup, find_world
from validation.worlds.scipy_world.hooks import Motion
from validation.worlds.scipy_world.plant import Plant

SCIPY = find_world("scipy")
WORLDS = [SCIPY, *([find_world("mujoco")] if importlib.util.find_spec("mujoco") else [])]
RIG = Rig(m=2.0, d=90.0, k_f=2000.0, k_c=2.0e5)
IMPACT = Impact(v_e=0.25, f_p=80.0)
TIME = np.arange(-20, 400) / 8000.0
LIBRARY = {
    "coulomb_friction": "actuator", "gravity": "actuator", "force_regulation": "actuator",
    "end_stop": "actuator", "contact_hardening": "contact", "contact_damping": "contact",
    "pad_relaxation": "contact", "pad_mass": "contact", "robot_compliance": "robot",
    "robot_deceleration": "robot", "sensor_lag": "sensor", "sensor_resonance": "sensor",
    "sensor_scale": "sensor", "pad_bottoming": "contact", "pretension_error": "actuator",
    "fixture_mass": "sensor",
}  # fmt: skip

each_world = pytest.mark.parametrize("world", WORLDS, ids=lambda world: world.name)
each_cause = pytest.mark.parametrize(
    ("world", "name"), [pytest.param(w, n, id=f"{w.name}-{n}") for w in WORLDS for n in sorted(w.causes())]
)


@each_world
def test_a_world_has_the_effects_of_the_contract_and_others_at_each_component(world):
    assert {name: cause.component for name, cause in world.causes("library").items()} == LIBRARY
    assert {cause.component for cause in world.causes("beyond").values()} == set(LIBRARY.values())


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


@each_world
@pytest.mark.parametrize("zeta", [0.0, 0.1, 0.7])
@pytest.mark.parametrize("impact", [Impact(0.05, 120.0), Impact(0.4, 0.0), IMPACT])
def test_without_causes_it_is_the_closed_form(world, zeta, impact):
    rig = Rig(m=2.0, d=2.0 * zeta * np.sqrt(2.0 * 2.02e5), k_f=2000.0, k_c=2.0e5)
    response = world.respond(rig, [], impact, TIME)
    touching = response.time >= 0.0
    expected = [closed_form(rig, impact, t) for t in response.time[touching]]
    np.testing.assert_allclose(response.contact[touching], expected, rtol=0.0, atol=2e-3)
    assert not response.contact[~touching].any()
    if np.isfinite(response.lost):
        assert abs(closed_form(rig, impact, response.lost)) < 0.02


@pytest.fixture(scope="module")
def setup():
    drawn = draw_setup(np.random.default_rng(2), coloured=False)
    return replace(drawn, conditions=drawn.conditions[-3:])


@each_cause
def test_a_small_cause_is_nearly_none_and_a_large_one_is_seen(world, name, setup):
    small, large = (distance(world, setup, [world.draw(name, 3, setup.rig, size)]) for size in (1e-4, 1.0))
    assert small < 2.0 < 6.0 < large


@each_cause
def test_equal_seeds_draw_equal_causes(world, name):
    assert world.draw(name, 7, RIG, 0.5) == world.draw(name, 7, RIG, 0.5)
    assert world.draw(name, 7, RIG, 0.5) != world.draw(name, 7, RIG, 0.25)


@each_cause
def test_contact_only_pushes_and_a_sensor_leaves_it_alone(world, name):
    cause, hard = world.draw(name, 5, RIG, 0.9), Impact(0.4, 60.0)
    response = world.respond(RIG, [cause], hard, TIME, after_loss=0.002)
    assert response.contact.min() >= 0.0
    nominal = world.respond(RIG, [], hard, response.time, after_loss=np.inf)
    unchanged = np.allclose(response.contact, nominal.contact, atol=1e-3)
    assert unchanged == (cause.component == "sensor")
    assert np.allclose(response.sensed, response.contact, atol=0.02) == (cause.component != "sensor")


@each_world
def test_any_two_effects_act_together(world):
    causes = {name: world.draw(name, 1, RIG, 0.5) for name in LIBRARY}
    each = {name: world.respond(RIG, [cause], IMPACT, TIME).sensed for name, cause in causes.items()}
    for names in combinations(LIBRARY, 2):
        response = world.respond(RIG, [causes[name] for name in names], IMPACT, TIME)
        assert np.isfinite(response.sensed).all() and response.contact.max() > 100.0, names
        for name in names:
            alone = each[name][: response.time.size]
            assert np.abs(response.sensed[: alone.size] - alone).max() > 0.5, names


@pytest.mark.parametrize(
    ("world", "name"), [pytest.param(w, n, id=f"{w.name}-{n}") for w in WORLDS for n in w.causes("beyond")]
)
def test_a_foreign_cause_acts_among_all_effects(world, name):
    hard = Impact(0.4, 100.0)
    small = [world.draw(one, 1, RIG, 0.02) for one in LIBRARY]
    with_it = world.respond(RIG, [world.draw(name, 1, RIG, 1.0), *small], hard, TIME).sensed
    without = world.respond(RIG, small, hard, TIME).sensed
    assert np.isfinite(with_it).all() and with_it.max() > 100.0
    n = min(with_it.size, without.size)
    assert np.abs(with_it[:n] - without[:n]).max() > 5.0


@pytest.mark.parametrize("name", ["gravity", "pad_mass", "sensor_scale", "robot_compliance"])
def test_engines_agree_where_their_forms_are_the_same(name):
    need_module("mujoco", 'pip install ".[worlds]"')
    for seed in (1, 2):
        one, other = (
            world.respond(RIG, [world.draw(name, seed, RIG, 0.5)], IMPACT, TIME) for world in WORLDS
        )
        n = min(one.time.size, other.time.size)
        assert one.lost == pytest.approx(other.lost, abs=2e-5)
        np.testing.assert_allclose(one.sensed[:n], other.sensed[:n], atol=0.02)


@dataclass(frozen=True)
class Expectation:
    """The sign of what a cause does to the largest contact force and to the loss of contact."""

    peak: int
    lost: int


@each_world
@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("coulomb_friction", Expectation(peak=1, lost=1)),
        ("force_regulation", Expectation(peak=1, lost=1)),
        ("end_stop", Expectation(peak=1, lost=1)),
        ("contact_hardening", Expectation(peak=1, lost=-1)),
        ("pad_bottoming", Expectation(peak=1, lost=-1)),
        ("robot_compliance", Expectation(peak=-1, lost=-1)),
        ("robot_deceleration", Expectation(peak=-1, lost=-1)),
    ],
)
def test_peak_and_duration_move_the_right_way(world, name, expected):
    nominal = world.respond(RIG, [], IMPACT, TIME)
    moved = world.respond(RIG, [world.draw(name, 1, RIG, 0.3)], IMPACT, TIME)
    assert np.sign(moved.contact.max() - nominal.contact.max()) == expected.peak
    assert np.sign(moved.lost - nominal.lost) == expected.lost


def test_a_sensor_of_unit_gain_passes_a_constant_force():
    for name in ("sensor_lag", "sensor_resonance"):
        for seed in range(6):
            cause = SCIPY.draw(name, seed, RIG, 0.5)
            reading = cause.read(np.arange(60000) * 1e-5, np.full(60000, 50.0))
            assert reading[0] == pytest.approx(0.0 if name == "sensor_lag" else 25.0)
            assert reading[-1] == pytest.approx(50.0, abs=1e-3)


def test_first_order_lag_is_the_exponential():
    lag = next(c for s in range(20) if (c := SCIPY.draw("sensor_lag", s, RIG, 0.5)).order == 1)
    time = np.arange(400) * 1e-5
    ramp = lag.read(time, 10.0 + 1e4 * time)
    decay = np.exp(-time / lag.delay)
    expected = 10.0 * (1.0 - decay) + 1e4 * (time - lag.delay * (1.0 - decay))
    np.testing.assert_allclose(ramp, expected, atol=1e-9)


def test_kelvin_voigt_and_hertz_forces_by_hand():
    damping = next(c for s in range(20) if not (c := SCIPY.draw("contact_damping", s, RIG, 0.5)).per_velocity)
    assert damping.contact(30.0, (), RIG, IMPACT, 1e-4, 0.1) == 30.0 + 0.1 * damping.viscous
    assert damping.contact(30.0, (), RIG, IMPACT, 1e-4, -100.0) == 0.0
    start = SCIPY.respond(RIG, [damping], IMPACT, TIME).contact[20]
    assert start == pytest.approx(80.0 + damping.viscous * 0.25)
    hertz = next(c for s in range(20) if not (c := SCIPY.draw("contact_hardening", s, RIG, 1.0)).gain)
    half, whole = (
        hertz.contact(RIG.k_c * s, (), RIG, IMPACT, s, 0.0) for s in np.array([0.5, 1.0]) * hertz.reference
    )
    assert whole / half == pytest.approx(2.0**1.5, rel=2e-3)


def test_the_contact_force_accelerates_pad_and_flange_together():
    rig = Rig(m=2.0, d=0.0, k_f=0.0, k_c=2.0e5)
    pad = SCIPY.draw("pad_mass", 1, rig, 1.0)
    plant = Plant(rig, [pad], IMPACT)
    moved = plant.initial + np.array([3e-4, 0.1, 4e-4, 0.2, 0.0])
    rates = plant.rates(1e-3, moved)
    assert rig.m * rates[1] + pad.mass * rates[3] == pytest.approx(plant.contact_force(1e-3, moved))
    assert rates[1] > 0.0


def test_a_yielded_pad_does_not_come_back():
    pad = SCIPY.draw("yielding_pad", 1, RIG, 1.0)
    plant = Plant(RIG, [pad], IMPACT)
    loaded, unloaded = (Motion(0.0, 0.0, 0.0, 1e-3, 0.0, pad.yield_force + sign * 50.0) for sign in (1, -1))
    assert pad.rates([0.0], RIG, IMPACT, loaded)[0] > 0.0 == pad.rates([1e-4], RIG, IMPACT, unloaded)[0]
    assert plant.contact_force(0.0, [0.0, 0.0, 1e-4]) < plant.contact_force(0.0, [0.0, 0.0, 0.0])


def test_unknown_names_are_refused_with_a_remedy():
    with pytest.raises(InputError, match="world 'nowhere' does not exist; there are"):
        find_world("nowhere")
    with pytest.raises(InputError, match="is not a cause of world 'scipy'; it has"):
        SCIPY.draw("ghost", 1, RIG, 1.0)

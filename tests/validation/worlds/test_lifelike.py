"""Lifelike rigs: what an effect does to the force is as large as it is said to be, and trials differ as they should."""

import csv
from dataclasses import replace

import numpy as np
import pytest
import yaml

from acf_jax.errors import InputError
from tests.needs import need_module
from validation.worlds import answer_of, draw_setup, find_world, make_lifelike, write_case
from validation.worlds.case import record_trials
from validation.worlds.lifelike import FREQUENCY, LARGE, SMALL, SPREAD, is_caught, size_by_share
from validation.worlds.setup import SAMPLE_RATES, Noise, Ring

SEED, EFFECTS = 3, ["sensor_lag", "end_stop"]


@pytest.fixture(scope="module")
def case():
    return make_lifelike(SEED, EFFECTS)


def check(case, effects, component):
    """Large and small causes as asked for, all of them acting; the answer names the large ones."""
    answer, world = answer_of(case), find_world(case.world)
    assert answer["effects"] == list(answer["shares"]) == effects
    assert answer["components"] == component
    assert all(LARGE[0] <= share <= LARGE[1] for share in answer["shares"].values())
    assert 4 <= len(answer["background"]) <= 6
    assert set(answer["background"]) <= set(world.causes("library")) - set(effects)
    assert all(SMALL[0] <= share <= SMALL[1] for share in answer["background"].values())
    assert list(case.causes) == [*effects, *answer["background"]] == list(answer["parameters"])
    assert case.setup.repeats >= 2 and SPREAD[0] <= case.setup.spread <= SPREAD[1]
    assert answer["ring_of_each_trial"] == (case.setup.ring is not None)
    h = case.held_out[-1]
    time = case.setup.time[case.setup.time >= 0.0]
    every = world.respond(case.setup.rig, list(case.causes.values()), h.impact, time).sensed
    np.testing.assert_array_equal(h.force, every)


@pytest.mark.long
def test_a_lifelike_rig_has_large_effects_among_small_ones(case):
    check(case, EFFECTS, ["actuator", "sensor"])
    assert not case.outside_library


def test_the_other_world_draws_them_too_and_a_foreign_cause():
    need_module("mujoco", 'pip install ".[worlds]"')
    foreign = make_lifelike(SEED, ["sensor_crosstalk"], world="mujoco")
    check(foreign, ["sensor_crosstalk"], ["sensor"])
    assert foreign.outside_library


@pytest.mark.long
def test_equal_arguments_make_equal_files_that_state_the_spread(case, tmp_path):
    write_case(case, tmp_path / "a")
    write_case(make_lifelike(SEED, EFFECTS), tmp_path / "b")
    files = sorted(p.relative_to(tmp_path / "a") for p in (tmp_path / "a").rglob("*") if p.is_file())
    assert all((tmp_path / "a" / f).read_bytes() == (tmp_path / "b" / f).read_bytes() for f in files)
    stated = yaml.safe_load((tmp_path / "a" / "dataset.yaml").read_text())["measurement"]
    assert stated["contact_velocity_rel_std"] == stated["pretension_rel_std"] == case.setup.spread
    with (tmp_path / "a" / "trials.csv").open() as file:
        assert len(list(csv.DictReader(file))) == len(case.setup.conditions) * case.setup.repeats


@pytest.mark.long
def test_an_impact_that_is_held_makes_no_lifelike_rig(case):
    """The flange does not swing back, and the robot pushes on: one trial is enough."""
    assert not is_caught(case)
    first, *others = case.trials
    for held in (replace(first, peak=2.5 * first.peak), replace(case.held_out[0], peak=1e4)):
        assert is_caught(replace(case, trials=(*others, held)))


@pytest.mark.parametrize("name", ["scipy", "mujoco"])
def test_the_share_of_a_wrong_scale_is_what_its_gain_lacks(name):
    if name == "mujoco":
        need_module("mujoco", 'pip install ".[worlds]"')
    setup = draw_setup(np.random.default_rng(1), coloured=False)
    sized = size_by_share(find_world(name), setup, "sensor_scale", 5, 0.01)
    assert sized.share == pytest.approx(abs(sized.cause.gain - 1.0), rel=1e-6)
    assert sized.share == pytest.approx(0.01, rel=0.05)


def test_every_trial_rings_at_an_amplitude_and_phase_of_its_own():
    world, drawn = find_world("scipy"), draw_setup(np.random.default_rng(4), coloured=False)
    ring = Ring(frequency=600.0, decay=0.5 * drawn.rig.half_period, share=0.02)
    quiet = {"noise": Noise(1e-9, 0.0), "spread": 0.0, "jitter": 0.0, "delay": 0.0, "quantum": 1e-9}
    setup = replace(drawn, **quiet, repeats=3, fault="", ring=ring)
    amplitudes = []
    for trial in record_trials(np.random.default_rng(0), world, setup, []):
        response = world.respond(setup.rig, [], trial.impact, setup.time, setup.after_loss)
        left = trial.force - response.sensed
        after = trial.time > 0.0
        assert np.abs(left[~after]).max() < 1e-6
        time = trial.time[after]
        waves = np.stack([np.cos(2 * np.pi * 600.0 * time), np.sin(2 * np.pi * 600.0 * time)], axis=1)
        basis = waves * np.exp(-time / ring.decay)[:, None]
        found, *_ = np.linalg.lstsq(basis, left[after])
        np.testing.assert_allclose(basis @ found, left[after], atol=1e-6)
        amplitudes += [found / response.sensed.max()]
    values = np.ravel(amplitudes)
    assert np.sqrt(np.mean(values**2)) == pytest.approx(ring.share, rel=4 / np.sqrt(2 * values.size))
    assert np.unique(values).size == values.size


def test_a_ring_is_slow_enough_for_every_recording():
    assert FREQUENCY[1] <= 0.35 * min(SAMPLE_RATES)


@pytest.mark.parametrize(
    ("effects", "fault"),
    [
        (["ghost"], "world 'scipy' has no cause ghost; it has"),
        (["gravity", "gravity"], "effects: gravity is named more than once"),
        (["gravity", "loose_pad"], "effects: gravity, loose_pad are too many large ones; name up to 3"),
        (["gravity", "pad_mass", "end_stop", "sensor_lag"], "are too many large ones; name up to 3"),
    ],
)
def test_effects_that_no_rig_can_have_are_refused(effects, fault):
    with pytest.raises(InputError, match=fault):
        make_lifelike(7, effects)

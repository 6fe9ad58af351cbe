"""Cases: deterministic, as varied as asked for, and written as the contract says."""

import csv
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.optimize import least_squares

from acf_jax.errors import InputError
from validation.worlds import Impact, answer_of, distance, draw_setup, find_world, make_case, write_case
from validation.worlds.distance import sensed, signature
from validation.worlds.imitation import LEAST, Imitation
from validation.worlds.interface import Rig
from validation.worlds.setup import DELAY, Noise

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def case():
    return make_case(11, ["gravity", "sensor_lag"], size=0.6, coloured=False)


def rows(path):
    with path.open() as file:
        return list(csv.DictReader(file))


def test_equal_arguments_make_equal_files(case, tmp_path):
    write_case(case, tmp_path / "a")
    write_case(make_case(11, ["gravity", "sensor_lag"], size=0.6, coloured=False), tmp_path / "b")
    files = sorted(p.relative_to(tmp_path / "a") for p in (tmp_path / "a").rglob("*") if p.is_file())
    assert len(files) == 4 + len(case.trials) + len(case.held_out)
    for file in files:
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


def test_the_data_set_has_the_contract_s_form(case, tmp_path):
    write_case(case, tmp_path)
    dataset = yaml.safe_load((tmp_path / "dataset.yaml").read_text())
    assert set(dataset) == {"schema", "description", "rig", "measurement"}
    assert dataset["schema"] == "acf-gap-dataset/1"
    assert set(dataset["rig"]) == {
        "moving_mass_kg", "damping_n_s_per_m", "actuator_stiffness_n_per_m", "contact_stiffness_n_per_m",
    }  # fmt: skip
    for entry in dataset["rig"].values():
        assert entry["value"] > 0.0 and entry["std"] > 0.0
    trials = rows(tmp_path / "trials.csv")
    assert len({row["trial"] for row in trials}) == len(trials) >= 3
    for row in trials:
        trace = np.loadtxt(tmp_path / row["trace"], delimiter=",", skiprows=1)
        time, force = trace.T
        assert np.all(np.diff(time) > 0.0) and time[0] < 0.0 < time[-1] and np.isfinite(force).all()
        assert abs(force[time < -2.0 * case.setup.interval].mean()) < 1.0
        assert float(row["peak_force_n"]) <= force.max() + 1e-9
    answer = yaml.safe_load((tmp_path / "answer.yaml").read_text())
    assert answer["effects"] == ["gravity", "sensor_lag"] and answer["components"] == ["actuator", "sensor"]
    for row in rows(tmp_path / "held_out_conditions.csv"):
        trace = np.loadtxt(tmp_path / "held_out_traces" / f"{row['trial']}.csv", delimiter=",", skiprows=1)
        assert trace[0, 0] == 0.0
        assert trace[:, 1].max() == pytest.approx(answer["held_out_peak_force_n"][row["trial"]], abs=2e-3)


def test_the_answer_can_be_kept_apart(case, tmp_path):
    write_case(case, tmp_path / "data", tmp_path / "answers" / "data.yaml")
    assert not list((tmp_path / "data").glob("answer*"))
    assert yaml.safe_load((tmp_path / "answers" / "data.yaml").read_text()) == answer_of(case)


@pytest.mark.parametrize("name", ["gravity", "contact_damping", "sensor_resonance"])
def test_a_target_distance_is_met(name):
    case = make_case(4, [name], target=8.0)
    assert distance(find_world("scipy"), case.setup, list(case.causes.values())) == pytest.approx(
        8.0, rel=0.05
    )
    assert case.distance == pytest.approx(8.0, rel=0.1)  # of the trials as they happened


def test_the_distance_is_that_of_the_sound_trials_as_they_happened():
    case = make_case(12, ["gravity"], size=0.3)
    assert [trial.fault for trial in case.trials].count("dropout") == 1
    world, causes = find_world("scipy"), list(case.causes.values())
    assert case.distance < 0.97 * distance(world, case.setup, causes)  # one trial of sixteen is lost
    happened = replace(case.setup, conditions=tuple(t.impact for t in case.trials), repeats=1)
    assert case.distance < distance(world, happened, causes)
    assert all(abs(t.impact.v_e / t.commanded.v_e - 1) < 5 * case.setup.spread for t in case.trials)


def test_distance_counts_repeats_and_falls_with_noise():
    world = find_world("scipy")
    setup = replace(draw_setup(np.random.default_rng(3), coloured=False), repeats=1)
    cause = world.draw("contact_hardening", 1, setup.rig, 0.05)
    once = distance(world, setup, [cause])
    assert once < distance(world, replace(setup, repeats=4), [cause]) <= 2.0 * once * (1.0 + 1e-9)
    louder = replace(setup, noise=Noise(10.0 * setup.noise.std, 0.0))
    assert distance(world, louder, [cause]) < once


def test_a_cause_that_another_rig_imitates_is_at_no_distance():
    """A light pad is like more mass and a softer contact, which move the loss of contact by several samples."""
    world, setup = find_world("scipy"), draw_setup(np.random.default_rng(8), coloured=False)
    heavier = replace(setup, rig=replace(setup.rig, m=1.015 * setup.rig.m, k_c=0.95 * setup.rig.k_c))
    traces = sensed(world, heavier, [])
    assert Imitation(setup, traces).best()[1] == pytest.approx(
        (0.015 * setup.rig.m / setup.prior[0][1]) ** 2 + (0.05 * setup.rig.k_c / setup.prior[3][1]) ** 2,
        rel=0.05,
    )


def test_a_cause_has_its_target_where_trials_almost_lose_contact():
    """Of this rig some trials just lose contact, and with the least of a cause they keep it."""
    case = make_case(1161955577, ["end_stop"], target=4.88)
    assert case.distance == pytest.approx(4.88, rel=0.1)


def test_the_distance_is_what_a_bounded_fit_leaves():
    """The rig that imitates a damped contact best has no spring at all: k_F stays at its bound."""
    world, drawn = find_world("scipy"), draw_setup(np.random.default_rng(5), coloured=False)
    setup = replace(drawn, conditions=drawn.conditions[2:5], interval=2 * drawn.interval)
    causes = [world.draw("contact_damping", 1, setup.rig, 0.05)]
    pairs, time = signature(world, setup, causes), setup.time[setup.time > 0.0]
    value, std = (
        np.array([setup.rig.m, setup.rig.d, setup.rig.k_f, setup.rig.k_c]),
        np.array(setup.prior)[:, 1],
    )
    trigger = max(setup.jitter, 0.5) * setup.interval / np.sqrt(3.0)
    common = DELAY * setup.interval / np.sqrt(3.0)

    def residual(z):
        theta, all_late, own = z[:4], z[4], z[5:].reshape(-1, 3)
        rows = [z[:5]]
        for impact, (_, force, _), (v, f, late) in zip(setup.conditions, pairs, own, strict=True):
            moved = Impact(impact.v_e * (1 + setup.spread * v), impact.f_p * (1 + setup.spread * f))
            shifted = time[: force.size] + all_late * common + late * trigger
            left = (
                force
                - world.respond(Rig(*(value + std * theta)), [], moved, shifted, after_loss=np.inf).sensed
            )
            rows += [
                np.sqrt(setup.repeats) * part for part in (setup.noise.whiten(left), np.array([v, f, late]))
            ]
        return np.concatenate(rows)

    low = np.concatenate([(LEAST - 1) * value / std, np.full(10, -np.inf)])
    fitted = least_squares(residual, np.zeros(14), bounds=(low, np.inf), diff_step=1e-4)
    assert fitted.x[2] == pytest.approx(low[2], rel=1e-3)
    assert distance(world, setup, causes) == pytest.approx(np.sqrt(2 * fitted.cost), rel=8e-3)


@pytest.mark.parametrize("coloured", [False, True])
def test_without_a_cause_nothing_but_noise_spread_and_trigger_is_left(coloured):
    """Residuals of the true rig, whitened with each trial's nuisances in their covariance, have unit variance."""
    world = find_world("scipy")
    case = make_case(3 if coloured else 4, coloured=coloured)
    setup, total, n = case.setup, 0.0, 0
    for trial in (trial for trial in case.trials if not trial.fault):
        velocity, pretension = trial.commanded

        def force(v_e, f_p, time=trial.time):
            return world.respond(setup.rig, [], Impact(v_e, f_p), time, after_loss=np.inf).sensed

        nominal = force(velocity, pretension)
        nuisances = [
            force(velocity * (1.0 + setup.spread), pretension) - nominal,
            force(velocity, pretension * (1.0 + setup.spread)) - nominal,
            np.gradient(nominal, trial.time) * setup.interval * setup.jitter / np.sqrt(3.0),
            np.gradient(nominal, trial.time) * setup.interval * DELAY / np.sqrt(3.0),
        ]
        kept = trial.time > 1.5 * setup.interval  # the step at time 0 is no small change of the trigger
        columns = setup.noise.whiten(np.stack(nuisances, axis=1)[kept])
        residual = setup.noise.whiten((trial.force - nominal)[kept])
        total += residual @ np.linalg.solve(np.eye(residual.size) + columns @ columns.T, residual)
        n += residual.size
    assert total / n == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / n))


def test_coloured_noise_has_the_deviation_and_memory_it_names():
    noise = Noise(std=2.0, memory=0.7)
    samples = noise.draw(np.random.default_rng(0), 40000)
    assert samples.std() == pytest.approx(2.0, rel=0.03)
    assert np.corrcoef(samples[1:], samples[:-1])[0, 1] == pytest.approx(0.7, abs=0.02)
    white = noise.whiten(samples)
    assert white.std() == pytest.approx(1.0, rel=0.02)
    assert abs(np.corrcoef(white[1:], white[:-1])[0, 1]) < 0.02


def test_an_effect_that_does_not_exist_is_refused():
    with pytest.raises(InputError, match="world 'scipy' has no cause ghost; it has"):
        make_case(1, ["ghost"])


@pytest.mark.parametrize(
    ("effects", "arguments", "fault"),
    [
        (["sensor_lag"], {"size": 0.0}, "size must be above 0, but is 0; leave effects out"),
        (["sensor_lag"], {"size": -0.5}, "size must be above 0, but is -0.5"),
        (["sensor_lag"], {"target": float("nan")}, "target must be above 0, but is nan"),
        (["gravity", "sensor_lag", "gravity"], {}, "effects: gravity is named more than once"),
    ],
)
def test_a_size_that_is_none_and_an_effect_named_twice_are_refused(effects, arguments, fault):
    with pytest.raises(InputError, match=fault):
        make_case(7, effects, **arguments)


def test_worlds_share_no_code_with_the_fitted_simulator():
    script = (
        "import sys; from validation.worlds import find_world; find_world('scipy').causes();"
        "parts = [m.split('.') for m in sys.modules];"
        "print(sorted({p[1] for p in parts if p[0] == 'acf_jax' and len(p) > 1}), ['jax'] in parts)"
    )
    out = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    assert out.strip() == "['documents', 'errors', 'files', 'folders'] False"

"""The benchmark of measured causes: what its scripts read from synthetic twins of the rigs, and how answers count."""

import json

import numpy as np
import pytest

from acf_jax.dataset import assess_dataset, read_dataset
from acf_jax.errors import InputError
from benchmarks.measured.__main__ import main
from benchmarks.measured.answers import Answer, outcome, read_answers
from benchmarks.measured.rigs import RIGS, cognifly, pcb_beam
from benchmarks.measured.score import score, table
from tests.benchmarks.measured_twins import TWINS


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    copies, out = tmp_path_factory.mktemp("copies"), tmp_path_factory.mktemp("sets")
    for folder, write in TWINS.items():
        write(copies / folder)
    assert main(["build", "--from", str(copies), "--out", str(out)]) == 0
    return {path.parent.name: read_dataset(path.parent) for path in out.glob("*/*/dataset.yaml")}


def test_every_set_has_an_answer_and_every_answer_a_set(built):
    assert set(built) == set(read_answers())
    assert len(built) >= 12 and len(RIGS) >= 6
    assert sum(len(d.trials) for d in built.values()) >= 150


def test_a_plot_is_read_to_the_sample(built):
    plate, label = built["jku_plate"], built["jku_label"]
    assert [t.pretension for t in plate.trials[:4]] == [15, 15, 10, 10]
    assert [t.pretension for t in label.trials] == [15, 15, 35, 35, 55, 55]
    slow = plate.trials[0]
    assert slow.contact_velocity == pytest.approx(0.1, rel=1e-3)
    assert np.median(np.diff(slow.trace.time)) == pytest.approx(1 / 1250, rel=1e-3)
    # the robot's dip, a fifth over 20 ms
    at_20_ms = np.interp(0.02, slow.motion.time, slow.motion.value)
    assert at_20_ms == pytest.approx(0.08, rel=0.02)
    assert all(t.motion is None for t in built["jku_brake"].trials)
    assert np.array_equal(built["jku_brake"].trials[0].trace.force, slow.trace.force)


def test_a_drop_gives_its_momentum_and_time_of_contact(built):
    for trial in built["cognifly_soft"].trials:
        assert abs(trial.trace.force[trial.trace.time < -0.001]).max() < 1.0
        impulse = np.trapezoid(trial.trace.force, trial.trace.time)
        # an elastic rebound gives twice the momentum; half a sample at either end is lost
        assert impulse == pytest.approx(2 * cognifly.MASS * trial.contact_velocity, rel=0.05)


def test_what_is_injected_is_in_the_recording_and_stated_where_it_should_be(built):
    soft, clipped, lag = (built[f"cognifly_{n}"] for n in ("soft", "clipped", "lag"))
    end = clipped.measurement.range_n
    assert max(t.trace.force.max() for t in clipped.trials) == pytest.approx(end, rel=1e-5)
    assert max(t.trace.force.max() for t in soft.trials) > 1.2 * end
    assert built["cognifly_filtered"].measurement.low_pass.zero_phase
    assert lag.measurement.low_pass is None
    peaks = [np.argmax(d.trials[0].trace.force) for d in (soft, lag)]
    assert peaks[1] > peaks[0]
    labels = [t.contact_velocity for t in built["cognifly_label"].trials]
    truth = [t.contact_velocity for t in soft.trials]
    differ = [t.name for t, a, b in zip(soft.trials, labels, truth, strict=True) if a != b]
    assert differ == read_answers()["cognifly_label"].right["excluded"]


def test_a_cart_hits_at_its_measured_speed(built):
    trial = built["pads_4mm"].trials[0]
    assert trial.contact_velocity == pytest.approx(0.87)
    impulse = np.trapezoid(trial.trace.force, trial.trace.time)
    assert impulse == pytest.approx(2 * 25 * 0.87, rel=0.03)


def test_shocks_ring_and_the_offset_of_faulty_ones_is_seen(built):
    board = built["pcb_disc_board"].trials[0].trace
    after = board.force[board.time > 2e-4]
    assert after.min() < -0.3 * after.max()
    said = " ".join(assess_dataset(built["pcb_disc_faulty"]).warnings)
    assert "t017 +2e+04 N, t024 +2e+04 N" in said
    beam = built["pcb_beam_board"]
    assert beam.measurement.range_n == pytest.approx(pcb_beam.RANGE)
    assert built["pcb_beam_silent"].measurement.range_n is None
    assert beam.trials[0].trace.force.max() == pytest.approx(pcb_beam.RANGE, rel=1e-5)
    assert 0 < beam.trials[0].trace.time[np.argmax(beam.trials[0].trace.force > 1000)] < 5e-4


def test_cones_and_hammer_have_their_speeds(built):
    rigid, firm = built["cone_rigid_60"], built["cone_firm_60"]
    assert len(rigid.conditions) == 5 and len(rigid.trials) == 15
    # a nose on a spring does not move with the body, whose inertia is read
    assert firm.trials[0].trace.force.max() < 0.95 * rigid.trials[0].trace.force.max()
    blue = np.array([(t.contact_velocity, t.peak_force) for t in built["amh_blue"].trials])
    power = np.polyfit(*np.log(blue).T, 1)[0]
    assert power == pytest.approx(1.3, abs=0.02)


def test_a_missing_copy_is_named(tmp_path, capsys):
    assert main(["build", "--from", str(tmp_path), "--out", str(tmp_path / "out")]) == 2
    assert "TwoBodyConeImpactData" in capsys.readouterr().err
    (tmp_path / "CrashLandingExperiments").mkdir()
    assert main(["build", "--from", str(tmp_path), "--out", str(tmp_path / "out")]) == 2
    assert "SoftBottom_50cm" in capsys.readouterr().err
    assert not (tmp_path / "out/cognifly").exists()


def test_changed_answers_are_refused(tmp_path):
    (tmp_path / "answers.yaml").write_text("sets: {}\n", "utf-8")
    (tmp_path / "answers.sha256").write_text("0" * 64 + "  answers.yaml\n", "utf-8")
    with pytest.raises(InputError, match="frozen"):
        read_answers(tmp_path)


def diagnosed(verdict, *explanations, component="contact", excluded=()):
    return {
        "verdict": verdict,
        "explanations": [{"effects": list(e)} for e in explanations],
        "credible_set": [list(e) for e in explanations],
        "where": {"component": {component: 0.9, "sensor": 0.1}},
        "excluded_trials": [{"trial": t} for t in excluded],
    }


PAD = Answer("a pad", {"effects": ["pad_bottoming"]}, absent=("actuator", "robot"))
WATER = Answer("water", {"component": "contact"})


@pytest.mark.parametrize(
    "answer, diagnosis, counts",
    [
        (PAD, diagnosed("identified", ["pad_bottoming"]), "right"),
        (PAD, diagnosed("identified", ["pad_bottoming", "gravity", "sensor_lag"]), "right"),
        (PAD, diagnosed("identified", ["pad_bottoming", "end_stop"]), "wrong"),
        (PAD, diagnosed("identified", ["contact_damping"]), "wrong"),
        (PAD, diagnosed("no_gap", []), "wrong"),
        (PAD, diagnosed("ambiguous", ["contact_damping"], ["pad_bottoming"]), "undecided"),
        (PAD, diagnosed("ambiguous", ["contact_damping"], ["gravity"]), "wrong"),
        (PAD, diagnosed("ambiguous", ["contact_damping"], ["unknown"]), "wrong"),
        (PAD, diagnosed("unknown", ["unknown"]), "unknown"),
        (PAD, diagnosed("insufficient_data", ["pad_bottoming"]), "insufficient data"),
        (WATER, diagnosed("unknown", ["unknown"]), "right"),
        (WATER, diagnosed("unknown", ["unknown"], component="robot"), "unknown"),
        (WATER, diagnosed("identified", ["contact_hardening"]), "wrong"),
        (WATER, diagnosed("ambiguous", ["contact_hardening"], ["unknown"]), "undecided"),
        (Answer("none", {"verdict": "no_gap"}), diagnosed("no_gap", []), "right"),
        (Answer("none", {"verdict": "no_gap"}), diagnosed("identified", ["gravity"]), "wrong"),
        (Answer("f", {"excluded": ["t1"]}), diagnosed("unknown", ["unknown"], excluded=["t1"]), "right"),
        (Answer("f", {"excluded": ["t1"]}), diagnosed("no_gap", [], excluded=["t2"]), "wrong"),
        (Answer("f", {"excluded": ["t1"]}), diagnosed("no_gap", []), "unknown"),
    ],
)
def test_what_an_answer_counts_as(answer, diagnosis, counts):
    assert outcome(answer, diagnosis) == counts


def test_injected_causes_are_counted_apart():
    rows = [
        {"rig": "a", "trials": 10, "injected": False, "outcome": "right"},
        {"rig": "a", "trials": 5, "injected": False, "outcome": "wrong"},
        {"rig": "b", "trials": 7, "injected": True, "outcome": "unknown"},
    ]
    text = table(rows)
    assert "| a | 2 | 15 | 1 | 1 | 0 | 0 | 0 |" in text
    assert "| all | 2 | 15 | 1 | 1 | 0 | 0 | 0 |" in text
    assert "| b, injected | 1 | 7 | 0 | 0 | 0 | 1 | 0 |" in text


def test_a_score_takes_the_diagnoses_that_are_there(tmp_path, built, capsys):
    folder = built["amh_blue"].folder
    out = tmp_path / "results"
    (out / "amh/amh_blue").mkdir(parents=True)
    found = diagnosed("insufficient_data", ["unknown"]) | {"gap": {}}
    found["explanations"][0]["probability"] = 0.6
    (out / "amh/amh_blue/diagnosis.json").write_text(json.dumps(found), "utf-8")
    score(folder.parents[1], out, only=["amh_blue"])
    assert "| amh | 1 | 24 | 0 | 0 | 0 | 0 | 1 |" in (out / "table.md").read_text("utf-8")
    with pytest.raises(InputError, match="holds no set"):
        score(tmp_path, out)


def test_a_set_without_an_answer_does_not_lose_the_others(tmp_path, built, monkeypatch):
    out = tmp_path / "results"
    found = diagnosed("insufficient_data", ["unknown"]) | {"gap": {}}
    found["explanations"][0]["probability"] = 0.6

    def only_the_white_tip(folder, result, without):
        assert not without
        if folder.name == "amh_blue":
            raise InputError([f"{folder}: no answer"])
        result.mkdir(parents=True)
        (result / "diagnosis.json").write_text(json.dumps(found), "utf-8")
        return 1.0

    monkeypatch.setattr("benchmarks.measured.score._diagnose", only_the_white_tip)
    with pytest.raises(InputError, match="amh_blue: no answer"):
        score(built["amh_blue"].folder.parents[1], out, only=["amh"])
    assert "| amh | 1 | 24 | 0 | 0 | 0 | 0 | 1 |" in (out / "table.md").read_text("utf-8")


def test_a_rig_is_told_without_what_it_does_not_have():
    """But for gravity, which acts on every rig; its owner knows as much."""
    without = read_answers()["cone_firm_60"].without
    assert "robot" in without and "end_stop" in without and not {"actuator", "gravity"} & set(without)
    assert not read_answers()["jku_brake"].without

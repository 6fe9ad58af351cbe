"""What can be asked of a model: the answers are those of the commands, and so are the warnings."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import acf_jax as acf
from acf_jax.api.forces import peak
from acf_jax.cli.main import main
from acf_jax.errors import InputError
from acf_jax.gap_model import write_model
from acf_jax.predict import predict
from tests.corrected import gap_model

ROOT = Path(__file__).resolve().parents[2]
RIG, MODEL, LEARNT = "configs/check_rig.yaml", "examples/rig_model.json", "examples/rig_surrogate.eqx"


@pytest.fixture(autouse=True)
def root(monkeypatch):
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr("acf_jax.start.start_jax", lambda: None)  # tests set JAX themselves


@pytest.fixture(scope="module")
def of_diagnosis():
    return acf.read_model(ROOT / MODEL)


def by_command(capsys, *arguments) -> dict:
    with pytest.raises(SystemExit):
        main([str(a) for a in (*arguments, "--json")])
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("path", [RIG, pytest.param(LEARNT, marks=pytest.mark.long)])
def test_the_speed_is_that_of_the_command(path, capsys):
    said = by_command(capsys, "speed", "--model", path, "--f-p", 60, "--limit", 90, "--limit", 1e3)
    model = acf.read_model(Path(path))
    low = model.speed(60, limit=90)
    assert (
        low.v == np.floor(said["speeds"][0]["v_e"] * 1e4) / 1e4
        and low.force == said["speeds"][0]["expected_force_n"]
    )
    assert f"{low.v:.4f} m/s" in repr(low) and "<pre>" in low._repr_html_()
    assert acf.speed(path, f_p=60.0, limit=90.0).v == low.v  # a path, and a function in place of a method
    none = acf.speed(RIG, f_p=60, limit=50)
    assert none.v is None and "lower the pretension" in repr(none)
    assert {trace.name for trace in low.plot().data} >= {"expected", "optimum"}


@pytest.mark.long
def test_the_verdict_is_that_of_the_command(capsys):
    model = acf.read_model(RIG)
    found = model.check("palm", v=0.2, f_p=60, stop_after=0.05)
    said = by_command(capsys, "check", "--model", RIG, "--body-area", "palm", "--contact", "quasi_static",
                      "--v-e", 0.2, "--f-p", 60, "--stop-after", 0.05)  # fmt: skip
    assert found.document() == said and found.is_allowed and found.verdict == "allowed"
    assert found.highest_speed == said["highest_allowed_velocity_m_per_s"] > 0.2
    assert repr(found).startswith("Allowed: Palm") and "does not replace a measurement" in repr(found)
    html = found._repr_html_()
    assert '<strong class="good">Allowed</strong>' in html
    (shown,) = re.findall(r"by this model: (.*)", repr(found))  # rounded down, and what ends there
    assert shown in html.replace("\xa0", " ") and float(shown.split()[0]) <= found.highest_speed
    open_end = model.check("palm", v=0.2, f_p=60)
    assert open_end.verdict == "not decidable" and not open_end.is_allowed
    assert any("how the contact ends" in reason for reason in open_end.reasons)
    assert (
        model.check("palm", v=0.2, f_p=60, contact="transient").answer.force_limit
        == 2 * found.answer.force_limit
    )


@pytest.mark.long
def test_the_design_is_that_of_the_command(capsys, tmp_path):
    config = {"model": str(ROOT / "configs/table1_rig.yaml"), "goal": "fastest", "limit": 250.0,
              "v_e": {"low": 0.05, "high": 0.5}, "f_p": {"low": 80.0, "high": 120.0}}  # fmt: skip
    (tmp_path / "design.yaml").write_text(json.dumps(config))
    said = by_command(capsys, "design", "--config", tmp_path / "design.yaml")
    model = acf.read_model("configs/table1_rig.yaml")
    found = model.design(250.0, v_e=(0.05, 0.5), f_p=(80.0, 120.0))
    assert found.is_feasible and found.values == said["optimum"] and found.upper <= 250.0
    assert found.document() | {"model": ""} == said | {"model": ""}
    assert "<table>" in found._repr_html_() and any(trace.type == "contour" for trace in found.plot().data)
    none = model.design(70.0, v_e=(0.05, 0.5), f_p=(80.0, 120.0))
    assert not none.is_feasible and "Not feasible" in repr(none)
    assert "raise limit from 70 to 90.31\xa0N" in none._repr_html_()


def test_a_design_in_a_notebook_rounds_no_speed_up_and_states_the_stop():
    found = acf.design(acf.Rig(m=4.0, d=0.0, k_f=0.0, k_c=175561.0), limit=260.0, v_e=(0.05, 0.5), f_p=100.0)
    assert 0.28635 < found.values["v_e"] < 0.2864  # sqrt(260^2 - 100^2)/838
    html = found._repr_html_().replace("\xa0", " ")
    assert "0.2863 m/s" in html and "the robot need not stop within 1 s" in html


def test_forces_of_a_diagnosis_are_predictions(of_diagnosis):
    found = of_diagnosis.peak([[0.1], [0.3]], [60.0, 80.0])
    assert found.force.shape == found.std.shape == (2, 2)
    (one,) = predict(of_diagnosis.source.gap, np.array([0.3]), np.array([80.0]))
    assert found.force[1, 1] == pytest.approx(one.contact_peak_force)
    assert found.std[1, 1] == pytest.approx(one.contact_peak_force_std)
    single = of_diagnosis.peak(0.3, 80)
    assert float(single) == found.force[1, 1] and single.force.shape == () and not single.notes
    assert "0.3 m/s        80 N       169.11" in repr(single)
    assert of_diagnosis.peak(0.3, 80, which="nominal").force != single.force


def test_forces_of_a_rig_and_of_a_surrogate():
    rig = acf.Rig(m=4.0, d=60.0, k_f=2000.0, k_c=175561.0)
    force = acf.speed(rig, f_p=100.0, limit=196.99).v
    assert force == pytest.approx(0.2, abs=2e-4)  # the peak at 0.2 m/s is 196.99 N
    net, exact = acf.load_surrogate(LEARNT), acf.read_model(MODEL)
    with pytest.warns(UserWarning, match=r"v_e = 0.5 m/s lies outside the trained 0.05 to 0.35"):
        found = net.peak([0.2, 0.5], 60)
    assert np.isnan(found.force[1]) and "none" in repr(found)
    assert abs(found.force[0] - 116.19) < found.error_bound[0] < 0.2
    assert "by a surrogate, wrong by less than 0.12 %" in repr(net) and "surrogate" not in repr(exact)


@pytest.mark.parametrize("change, says", [
    ({"better": False}, "not better than the recalibrated one"),
    ({"shown_closer": False}, "do not show that the corrected model comes closer"),
    ({"verdict": "insufficient_data"}, "too little data"),
    ({}, None),
])  # fmt: skip
def test_what_the_data_do_not_carry_is_warned_of(change, says, recwarn):
    model = gap_model().model_copy(update=change)
    told = peak(model, 0.2, 70.0)  # what the library knows will do as well
    warned = [str(w.message) for w in recwarn]
    assert warned == list(told.notes)
    assert (len(warned) == 1 and says in warned[0]) if says else not warned


def test_beyond_the_trials_is_warned_of_at_the_line_that_asks():
    with pytest.warns(UserWarning, match="0.36 m/s lies outside the tried 0.05 to 0.35 m/s") as told:
        acf.read_model(MODEL).peak(0.36, 60)
    assert told[0].filename == __file__


def test_too_little_data_decide_nothing(tmp_path):
    (tmp_path / "model.json").write_text(
        write_model(gap_model().model_copy(update={"verdict": "insufficient_data"}))
    )
    model = acf.read_model(tmp_path)
    assert model.check("palm", v=0.1, f_p=60, stop_after=0.05).verdict == "not decidable"
    assert "too little data" in repr(model)
    asks = (
        lambda: model.speed(60, limit=140, draws=512),
        lambda: model.design(limit=140, v_e=(0.1, 0.3), f_p=60),
        lambda: model.train(steps=1),
    )
    for ask in asks:
        with pytest.raises(InputError, match="the diagnosis had too little data to answer: its trials"):
            ask()


@pytest.mark.parametrize("ask, says", [
    (lambda m: m.speed("60", limit=140), "f_p must be a finite number, but is '60'"),
    (lambda m: m.speed(60, limit=None), "limit must be a finite number, but is None"),
    (lambda m: m.speed(60, limit=0.1), "limit must be at least 1 N, but is 0.1; if it is in kN"),
    (lambda m: m.speed(60, limit=140, stop_after=20), "stop_after must be at most 10 s"),
    (lambda m: m.speed(60, limit=140, probability=95), "probability must lie between 0.5 and 0.9999, but is 95"),
    (lambda m: m.check("palm", v=200, f_p=60), "v must be at most 5 m/s, but is 200; if it is in mm/s"),
    (lambda m: m.check("pam", v=0.2, f_p=60), "body area 'pam' is not in"),
    (lambda m: m.check("palm", v=0.2, f_p=60, contact="clamped"), "contact is 'clamped'; write transient or quasi"),
    (lambda m: m.check("palm", v=0.2, f_p=60, payload=3.0), "moving_mass and payload belong together"),
    (lambda m: m.check("palm", v=None, f_p=60), "v must be a finite number, but is None"),
    (lambda m: m.design(250, v_e=0.2, f_p=(50, 80)), "design: goal: fastest needs v_e to be free"),
    (lambda m: m.design(250, v_e=(0.1, 0.3), f_p=60, free={"k_x": (1, 2)}), "design: free.k_x: is not a parameter"),
    (lambda m: m.peak(200, 60), "peak.v_e must be at most 5 m/s, but is 200; if it is in mm/s"),
    (lambda m: m.peak([0.1, 0.2], [1.0, 2.0, 3.0]), "v and f_p must broadcast"),
    (lambda m: m.peak([], 60), "v and f_p hold no impact"),
    (lambda m: m.design(250, v_e=(0.1, 0.3), f_p=60, free=3), "design: free: must hold `key: value` pairs, but is 3"),
    (lambda m: m.design(250, v_e=(0.1, object()), f_p=60), "design: v_e.high: must be a number, but is '<object"),
    (lambda m: acf.train(MODEL, "README.md"), "README.md: is a file; name a folder"),
    (lambda m: acf.train(MODEL, samples="x"), "train: samples.train: must be a whole number"),
    (lambda m: acf.diagnose("examples/rig", seed="x"), "seed: must be a whole number"),
    (lambda m: acf.find_peak(m, 2), "find_peak takes a Rig and an Impact"),
    (lambda m: m.peak(0.2, 60, which="nominal"), "which: only a diagnosis has several models"),
    (lambda m: m.export_c("peak.h"), "holds none; train one first"),
    (lambda m: m.save("model.eqx"), "save: the model holds no surrogate"),
    (lambda m: m.train(), "train: the paper's model has an exact peak already"),
    (lambda m: acf.speed(3, f_p=60, limit=140), "model: is 3, no model; give a diagnosis"),
    (lambda m: acf.speed("none.yaml", f_p=60, limit=140), "none.yaml: no such file"),
    (lambda m: acf.speed(acf.Rig([4.0, 5.0], 0, 0, 1e5), f_p=60, limit=140), "Rig.m: must be one number here"),
    (lambda m: acf.export_c("peak.txt"), "peak.txt: must end in .h"),
    (lambda m: acf.export_c("double.h", LEARNT), "the file's name names the function; `double` is a name of C"),
    (lambda m: acf.read_dataset(3), "3 is no path"),
    (lambda m: acf.diagnose("examples/rig", rig=3.0), "rig: a diagnosis needs standard deviations"),
])  # fmt: skip
def test_what_cannot_be_asked_is_told_with_the_remedy(ask, says):
    with pytest.raises(InputError) as told:
        ask(acf.read_model(RIG))
    assert any(fault.startswith(says) or says in fault for fault in told.value.faults), told.value.faults


def test_headers_are_those_of_the_command(capsys, tmp_path):
    assert acf.export_c(str(tmp_path / "a.h")) == tmp_path / "a.h"
    with pytest.raises(SystemExit):
        main(["export", "--c", str(tmp_path / "b.h")])
    assert (tmp_path / "a.h").read_text() == (tmp_path / "b.h").read_text()
    net = acf.load_surrogate(LEARNT)
    acf.export_c(tmp_path / "peak.h", net)
    assert "static peak_result peak(double m," in (tmp_path / "peak.h").read_text()
    assert net.save(tmp_path / "copy.eqx").read_bytes() == Path(LEARNT).read_bytes()


def test_a_script_of_a_user_reads_and_types():
    """A fresh Python; mypy knows the arguments of a method that is a function of the package."""
    code = "import acf_jax as acf; print(acf.read_model('configs/table1_rig.yaml').peak(0.2, 100).force.round(2))"
    assert subprocess.check_output([sys.executable, "-c", code], text=True).strip() == "195.17"

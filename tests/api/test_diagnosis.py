"""A diagnosis in Python, from the recording to the header: what the ten lines of docs/python.md do."""

import json
import re
import shutil
import subprocess
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

import acf_jax as acf
from acf_jax.api import training
from acf_jax.dataset import LowPass
from acf_jax.dataset.description import LowPassForm
from acf_jax.diagnosis import Diagnosis
from acf_jax.diagnosis.results import gap_model
from acf_jax.errors import InputError
from acf_jax.predict import predict
from acf_jax.report import told
from acf_jax.training.default import default_config
from tests.api.conftest import KNOWN, SIGNALS
from tests.few import few_explanations
from tests.needs import need_program

ROOT = Path(__file__).resolve().parents[2]
EVIL = "<img src=x onerror=\"document.title='owned'\">"


@pytest.fixture(scope="module")
def net(diagnosed):
    return diagnosed.train(samples=2048, steps=300)


def test_it_is_the_library_s_diagnosis_without_the_dropped_trial(diagnosed):
    assert isinstance(diagnosed, Diagnosis) and "t011" not in diagnosed.observations.names
    assert len(diagnosed.dataset.trials) == 11 and diagnosed.dataset.rig.m.value == 2.1
    assert repr(diagnosed) == told(diagnosed) and diagnosed.verdict in diagnosed.document()["verdict"]


def test_its_answers_are_those_of_the_model_that_it_leaves(diagnosed):
    (one,) = predict(gap_model(diagnosed), np.array([0.2]), np.array([80.0]))
    found = diagnosed.peak(0.2, 80, which="corrected")
    other = predict(gap_model(diagnosed), np.array([0.2]), np.array([80.0]), "corrected")[0]
    assert found.force == other.contact_peak_force and found.std == other.contact_peak_force_std
    assert diagnosed.model.peak(0.2, 80).force == one.contact_peak_force
    assert found.sensed == other.peak_force


def test_what_is_saved_answers_the_same(diagnosed, tmp_path):
    report = diagnosed.save(str(tmp_path / "kept"))
    assert "<!doctype html>" in report.read_text("utf-8")
    assert json.loads((tmp_path / "kept/diagnosis.json").read_text()) == json.loads(
        json.dumps(diagnosed.document())
    )
    kept = acf.read_model(tmp_path / "kept")
    assert kept.peak(0.2, 80).force == diagnosed.peak(0.2, 80).force


def test_a_cutoff_is_the_filter_of_the_command(press):
    session = acf.read_recording(press, **SIGNALS)
    for wrong, fault in (
        ("200", "low_pass must be a finite number"),
        (-1.0, "cutoff_hz"),
        (1e5, "cutoff_hz"),
    ):
        with pytest.raises(InputError, match=fault):
            acf.diagnose(session, rig=acf.Prior(**KNOWN), low_pass=wrong)
    with few_explanations(("gravity",), ("unknown_actuator",)):
        found = acf.diagnose(session, rig=acf.Prior(**KNOWN), low_pass=np.float64(600))
    assert found.dataset.measurement.low_pass == LowPass(600.0, order=4)
    assert gap_model(found).low_pass == LowPassForm(cutoff_hz=600.0, order=4)


@pytest.mark.parametrize("what", [None, "force", "peaks", "explanations", "made_of", "where"])
def test_its_figures_are_those_of_the_report(diagnosed, what):
    figure = diagnosed.plot(what)
    assert figure.data and any(trace.visible is not False for trace in figure.data)
    assert "--" not in re.sub(r"-->|<!--", "", str(figure.to_dict().get("layout", {}).get("shapes", "")))
    if what == "force":
        menu = figure.layout.updatemenus[0]
        assert len(menu.buttons) == 11
        shown, layout = menu.buttons[0].args
        assert len(shown["visible"]) == len(figure.data) and layout["shapes"]


def test_a_figure_that_it_does_not_have_is_told(diagnosed):
    with pytest.raises(InputError, match="'forse' is no figure; known are force, peaks"):
        diagnosed.plot("forse")
    bare = replace(diagnosed, observations=replace(diagnosed.observations, peak_only=np.ones(11, bool)))
    with pytest.raises(InputError, match="have no figure 'force'"):
        bare.plot("force")


def test_its_html_is_escaped(diagnosed):
    name = diagnosed.observations.names[0]
    evil = replace(diagnosed, excluded={name: EVIL})
    assert "<img" not in evil._repr_html_() and "&lt;img" in evil._repr_html_()
    assert diagnosed._repr_html_().count("<table>") >= 1


def test_a_data_set_takes_another_rig(monkeypatch):
    seen = []
    monkeypatch.setattr("acf_jax.diagnosis.diagnose", lambda data, *rest: seen.append(data) or 1 / 0)
    with pytest.raises(ZeroDivisionError):
        acf.diagnose(ROOT / "examples/rig", rig=acf.Prior(m=(2, 1), d=(1, 1), k_f=(1, 1), k_c=(1e5, 1e4)))
    with pytest.raises(ZeroDivisionError):
        acf.diagnose(acf.read_dataset(str(ROOT / "examples/rig")))
    assert [data.rig.m.value for data in seen] == [2, 1.74762]
    assert {f.name for f in fields(seen[0])} == {f.name for f in fields(seen[1])}


def test_an_effect_that_is_none_is_told():
    with pytest.raises(InputError, match="no effect is called 'gravty'"):
        acf.diagnose(ROOT / "examples/rig", without=["gravty"])


def test_a_surrogate_says_what_the_model_says(diagnosed, net, tmp_path):
    v_e, f_p = np.array([0.1, 0.2, 0.3]), 80.0
    exact, learnt = diagnosed.peak(v_e, f_p), net.peak(v_e, f_p)
    assert (np.abs(learnt.force - exact.force) < learnt.error_bound + 0.01).all()
    again = acf.load_surrogate(net.save(tmp_path / "net.eqx"))
    assert again.peak(0.2, f_p).force == learnt.force[1]
    assert "by a surrogate" in repr(again) and "<table>" in again._repr_html_()


def test_its_header_compiles_and_answers(net, tmp_path):
    compiler = need_program("cc", "gcc", "clang")
    header = net.export_c(tmp_path / "peak.h")
    call = re.search(r"peak_result r = (peak\(.*\));", header.read_text())[1]
    names = call.removeprefix("peak(").removesuffix(")").split(", ")
    source, model = net.source, net.source.exact
    values = dict(zip(map(lambda n: n.replace(".", "_"), model.names), model.at(0.2, 80.0), strict=True))
    arguments = ", ".join(repr(float(values[name])) for name in names)
    program = f'#include <stdio.h>\n#include "peak.h"\nint main(void) {{ printf("%.9f", peak({arguments}).f_max); }}'
    (tmp_path / "main.c").write_text(program)
    subprocess.run([compiler, "main.c", "-lm", "-o", "main"], cwd=tmp_path, check=True)
    printed = subprocess.check_output([tmp_path / "main"], text=True)
    assert (
        float(printed) == pytest.approx(float(net.peak(0.2, 80.0)), rel=1e-6) and source.trained is not None
    )


def test_ranges_that_cannot_be_are_named(diagnosed, tmp_path):
    with pytest.raises(InputError) as told_:
        diagnosed.train(tmp_path, ranges={"k_c": (1e4, 2e4), "v": (0.1, 0.2), "f_p": (80, 60)}, samples=2048)
    said = "\n".join(told_.value.faults)
    assert "ranges.f_p: low (80) must be below high (60)" in said
    with pytest.raises(InputError) as told_:
        diagnosed.train(tmp_path, ranges={"k_c": (1e4, 2e4), "v": (0.1, 0.2)}, samples=2048)
    said = "\n".join(told_.value.faults)
    assert (
        "ranges.k_c: 10000 to 20000 N/m leaves out the fitted" in said and "ranges.v: is no quantity" in said
    )
    with pytest.raises(InputError, match=r"train: samples.train: .*but is 10"):
        diagnosed.train(samples=10)


@pytest.mark.long
def test_the_ten_lines_of_the_page_run(monkeypatch, tmp_path, capsys):
    """As they stand, with few effects and a short training in place of minutes."""
    page = (ROOT / "docs/python.md").read_text("utf-8")
    code = re.search(r"```python\n(import acf_jax as acf\n.*?)```", page, re.DOTALL)[1]
    assert len([line for line in code.splitlines() if line.strip()]) <= 12
    assert code in (ROOT / "README.md").read_text("utf-8")
    shutil.copytree(ROOT / "examples", tmp_path / "examples", ignore=shutil.ignore_patterns("rig", "*.py"))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("plotly.graph_objects.Figure.show", lambda figure: print(len(figure.data), "curves"))
    monkeypatch.setattr(training, "default_config", lambda *a, **k: default_config(*a[:4], 2048, 300))
    with few_explanations(("end_stop",), ()):
        names: dict = {}
        exec(compile(code, "docs/python.md", "exec"), names)
    printed = capsys.readouterr().out
    assert "3 curves" in printed and "end stop" in printed and "140 N" in printed and "m/s" in printed
    assert names["d"].scored[0].explanation == ("end_stop",) and len(names["d"].dataset.trials) == 15
    assert "static peak_result peak(" in (tmp_path / "peak.h").read_text()

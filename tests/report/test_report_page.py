"""The page as text: what it holds, and that nothing of a data set is taken for HTML."""

import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import plotly.graph_objects as go
import pytest
from click.testing import CliRunner

from acf_jax.cli.diagnose import command
from acf_jax.dataset import GapDataset
from acf_jax.dataset.trust import Limit
from acf_jax.diagnosis.claims import Change, Comparison
from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.diagnosis.document import document
from acf_jax.diagnosis.experiment import Experiment
from acf_jax.diagnosis.heldout import largest_reading
from acf_jax.diagnosis.results import gap_model
from acf_jax.evidence.posterior import Scored
from acf_jax.inference.forward import Grid, forward
from acf_jax.inference.parameters import every_effect
from acf_jax.report import sentence, write_report
from acf_jax.report.discrepancy import along
from acf_jax.report.markup import formula
from acf_jax.report.outlook import outlook
from acf_jax.report.parameters import parameter_table
from acf_jax.report.peaks import by_condition
from acf_jax.report.quality import _range
from acf_jax.report.summary import consequence
from acf_jax.report.traces import overlay
from acf_jax.report.where import gap_map
from acf_jax.report.words import VERDICTS, advice, headed, listed, next_step, of_removed, percent, si, verdict


class Page(HTMLParser):
    """Elements and visible text of a page, and its figures."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.text, self.figures = "", {}
        self._data = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        tag, attributes = self.elements[-1] if self.elements else ("", {})
        if tag == "script" and attributes.get("type") == "application/json":
            self.figures[attributes["id"]] = json.loads(data)
        elif self.cdata_elem is None:
            self.text += data


def read(diagnosis: Diagnosis, folder: Path) -> Page:
    path = folder / "report.html"
    write_report(path, diagnosis, document(diagnosis))
    return Page(path.read_text("utf-8"))


def test_holds_what_an_engineer_asks_for(diagnosed: Diagnosis, tmp_path: Path) -> None:
    page = read(diagnosed, tmp_path)
    titles = {
        "made-of-bars",
        "causes",
        "spectrum",
        "overlay",
        "map",
        "component",
        "evidence",
        "force-error",
        "peak-error",
        "peaks",
    }
    assert {name.removesuffix("-data") for name in page.figures} == titles
    kept = len(diagnosed.observations.names)
    assert len(page.figures["overlay-data"]["variants"]) == kept + len(diagnosed.excluded)
    for name in document(diagnosed)["parameters"]:
        assert name in page.text
    levels = [int(tag[1]) for tag, _ in page.elements if re.fullmatch("h[1-6]", tag)]
    assert levels[0] == 1 and all(b - a <= 1 for a, b in pairwise(levels))


def test_needs_no_other_file_and_no_network(diagnosed: Diagnosis, tmp_path: Path) -> None:
    page = read(diagnosed, tmp_path)
    for tag, attributes in page.elements:
        assert tag not in ("link", "iframe", "img")
        assert "src" not in attributes
        assert (attributes.get("href") or "#").startswith("#")
    policy = next(a["content"] for t, a in page.elements if a.get("http-equiv") == "Content-Security-Policy")
    assert (
        "default-src 'none'" in policy and "unsafe-inline" not in policy.split("script-src")[1].split(";")[0]
    )


@pytest.mark.parametrize("case", ["diagnosed", "unknown", "peaks_only"])
def test_texts_of_the_data_set_stay_texts(case: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    page = read(request.getfixturevalue(case), tmp_path)
    assert not any(name.startswith("on") for _, attributes in page.elements for name in attributes)
    scripts = [a for tag, a in page.elements if tag == "script" and a.get("type") != "application/json"]
    assert len(scripts) == 2
    assert "a <b>rig</b> </script><img src=x onerror=" in page.text
    assert not any(tag == "b" for tag, _ in page.elements)
    drawn = json.dumps([v["data"] for f in page.figures.values() for v in f["variants"]])
    assert "<img" not in drawn  # Plotly reads some HTML


@pytest.mark.parametrize("case", ["diagnosed", "unknown", "peaks_only"])
def test_figures_are_plotly_figures(case: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    page = read(request.getfixturevalue(case), tmp_path)
    for figure in page.figures.values():
        plain = json.loads(re.sub(r'"--[a-z0-9-]+"', '"#123456"', json.dumps(figure)))
        for variant in plain["variants"]:
            go.Figure(variant["data"], {**plain["layout"], **variant["layout"]})


def test_colours_of_the_figures_are_those_of_the_style_sheet(unknown: Diagnosis, tmp_path: Path) -> None:
    page = read(unknown, tmp_path)
    used = set(re.findall(r'"(--[a-z0-9-]+)"', json.dumps(page.figures)))
    text = (tmp_path / "report.html").read_text("utf-8")
    light, dark = (
        re.search(r":root \{(.*?)\}", text, re.S),
        re.search(r"dark\) \{\s*:root \{(.*?)\}", text, re.S),
    )
    assert light and dark
    for sheet in (light[1], dark[1]):
        assert used <= set(re.findall(r"(--[a-z0-9-]+):", sheet))


@pytest.mark.parametrize("verdict", VERDICTS)
def test_each_verdict_has_its_sentence(verdict: str, diagnosed: Diagnosis, tmp_path: Path) -> None:
    d = replace(diagnosed, verdict=verdict)
    assert VERDICTS[verdict][0].split()[0] in sentence(d)
    assert VERDICTS[verdict][0] in read(d, tmp_path).text


def test_a_class_that_the_trials_cannot_split_is_named_whole(diagnosed: Diagnosis) -> None:
    scored = (Scored(("coulomb_friction",), 0.71), Scored(("gravity",), 0.28), Scored((), 0.01))
    alike = tuple(s.explanation for s in scored[:2])
    says = verdict(
        replace(diagnosed, verdict="identified", told=diagnosed.told._replace(scored=scored), credible=alike)
    )
    assert says == (
        "Identified: dry friction (71 %) or constant force on the flange (gravity) (28 %), which these trials cannot"
        " tell apart, at the actuator."
    )


def test_advice_is_of_the_first_explanation_and_says_whether_others_remain(
    diagnosed: Diagnosis, unknown: Diagnosis
) -> None:
    scored = (Scored(("coulomb_friction", "sensor_lag"), 0.97), Scored((), 0.03))
    sure = replace(
        diagnosed,
        verdict="identified",
        told=diagnosed.told._replace(scored=scored),
        credible=(scored[0].explanation,),
    )
    assert advice(sure) == (
        "On the machine: clean and lubricate the guide, and check the seals and the alignment of the flange (dry"
        " friction); raise the cut-off frequency of the sensor's filter (sensor lag)."
    )
    both = replace(sure, verdict="ambiguous", credible=(scored[0].explanation, ()))
    assert advice(both).startswith("On the machine, if it is the first of these: clean and")
    assert advice(unknown) == "" and advice(replace(sure, verdict="insufficient_data")) == ""
    assert (
        advice(
            replace(sure, verdict="no_gap", told=diagnosed.told._replace(scored=scored[1:]), credible=((),))
        )
        == ""
    )


def test_each_verdict_says_what_is_next(diagnosed: Diagnosis, peaks_only: Diagnosis) -> None:
    trial = Experiment(0.35, 90.0, 2, (("coulomb_friction",), ("gravity",)), 0.3, 0.01)
    open_ = replace(diagnosed, verdict="ambiguous", next_experiment=trial)
    assert next_step(open_) == (
        "Next: measure 2 trials at 0.35 m/s, 90 N, and diagnose them with the others: that separates dry friction from"
        " constant force on the flange (gravity) best."
    )
    where = {"actuator": 0.1, "contact": 0.2, "robot": 0.7, "sensor": 0.0}
    unknown = replace(diagnosed, verdict="unknown", component=where, next_experiment=None)
    assert next_step(unknown) == "Next: look at the robot for what no effect describes."
    assert next_step(replace(diagnosed, verdict="no_gap")).startswith("Next: nothing to correct")
    assert next_step(peaks_only) == f"Next: {gap_model(peaks_only).missing}."
    assert next_step(replace(diagnosed, verdict="identified")) == ""


def test_intervals_of_parameters_are_those_of_the_stated_deviations(diagnosed: Diagnosis) -> None:
    """A misfit beyond the noise widens both."""
    d = diagnosed.corrected
    astray = replace(d, misfit=16 * d.misfit)
    stated = document(replace(diagnosed, corrected=astray))["parameters"]["moving_mass_kg"]
    ends = [si(stated["value"] + sign * 1.959964 * stated["std"]) for sign in (-1, 1)]
    assert " to ".join(ends) in parameter_table(replace(diagnosed, corrected=astray))


def test_peaks_alone_are_told_what_to_measure(peaks_only: Diagnosis, tmp_path: Path) -> None:
    assert gap_model(peaks_only).missing.startswith("its trials hold peaks and no force traces; record")
    page = read(peaks_only, tmp_path)
    conditions = document(peaks_only)["where"]["conditions"]
    assert all(c["excess_rms_n"] is None and c["share"] >= 0 for c in conditions)
    assert "overlay-data" not in page.figures and "force-error-data" not in page.figures
    assert "Record force traces" in page.text


def test_measured_peaks_are_compared_with_peaks_of_their_kind(
    diagnosed: Diagnosis, peaks_only: Diagnosis
) -> None:
    """The largest of noisy samples with what one expects of it; a peak that was only told, with the peak."""
    o, look = diagnosed.observations, outlook(diagnosed)
    force = look.trials[o.names[0]].force
    expected = largest_reading(force, o.noise.std, np.empty((0, len(force))))
    assert expected > look.trials[o.names[0]].peak_force + o.noise.std
    shown = by_condition(diagnosed, look)
    assert f">{expected:.1f} ± " in shown and "what noise adds to the largest sample" in shown
    told = outlook(peaks_only)
    alone = by_condition(peaks_only, told)
    assert f">{told.trials[o.names[0]].peak_force:.1f} ± " in alone and "noise adds" not in alone


def test_of_a_single_condition_nothing_is_said_to_be_held_out(diagnosed: Diagnosis) -> None:
    o, look = diagnosed.observations, outlook(diagnosed)
    alone = replace(diagnosed, observations=replace(o, condition=np.zeros_like(o.condition)))
    assert "did not see the trial&#x27;s condition; the contact force by the fit to all" in overlay(
        diagnosed, look
    )
    assert "did not see" in gap_map(diagnosed)
    assert "did not see" not in overlay(alone, look) and "did not see" not in gap_map(alone)


def test_nothing_is_claimed_of_a_correction_that_is_no_better(diagnosed: Diagnosis, tmp_path: Path) -> None:
    """No share, no corrected peak, no speed: the figures beside them say the opposite."""
    worse = Comparison(Change(7.13, 9.81), Change(55.0, 20.0))
    content = document(diagnosed)
    assert content["corrected_is_better"] is True
    page = read(diagnosed, tmp_path)
    assert (
        "Correcting for it removes" in page.text
        or "Correcting for the most probable one removes" in page.text
    )
    assert "Corrected model, ±" in page.text and "Gap removed, force" in page.text
    said = "not better than the recalibrated one (force error 7.13 → 9.81 N, peak error 55 → 20 %)"
    page = read(replace(diagnosed, comparison=worse, shrinkage_force=None, shrinkage_peak=None), tmp_path)
    text = page.text.replace("\u00a0", " ")
    assert said in text and "No shrinkage is stated: the corrected model is not better" in text
    for claim in (
        "Correcting for",
        "Gap removed",
        "To stay below",
        "Allowed speeds",
        "the corrected model gives",
    ):
        assert claim not in text, claim
    assert "Recalibrated model, ±" in page.text and "Corrected model, ±" not in page.text
    names = {t.get("name") for v in page.figures["peaks-data"]["variants"] for t in v["data"]}
    assert names >= {"recalibrated, contact", "nominal"} and not any(
        "corrected" in str(name) for name in names
    )


def test_doubts_about_the_data_come_before_the_verdict(
    diagnosed: Diagnosis, evil_set: GapDataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = diagnosed.observations.names[0]
    limits = (Limit("saturation", "the force is cut off"),)
    quality = replace(diagnosed.quality, damaged=(name,), limits=limits)
    damaged = replace(diagnosed, quality=quality, highest=0.9, excluded={"t001": "its force drops out"})
    monkeypatch.setattr("acf_jax.diagnosis.diagnose", lambda *_, **__: damaged)
    monkeypatch.setattr("acf_jax.dataset.read_dataset", lambda _: evil_set)
    result = CliRunner().invoke(command, ["set", "--out", str(tmp_path / "out")])
    lines = result.stdout.splitlines()
    of, count = len(evil_set.trials), len(diagnosed.observations.names)
    assert result.exit_code == 0
    head = f"Data: limited by trials left out, saturation, no repeats; {count} trials at {count} conditions"
    assert lines[0].startswith(head), lines[0]
    lines = [line for line in lines if "no condition is repeated" not in line]
    assert lines[1:4] == [
        f"note: 1 of {of} trials is left out (t001: its force drops out)",
        "note: the force is cut off",
        f"note: no probability above 90 % is stated: 1 of the {count} trials compared are damaged, and what one of"
        " these shows may as well be its damage",
    ]
    assert lines[4] == sentence(damaged)


def test_a_peak_that_is_cut_off_is_a_lower_bound(diagnosed: Diagnosis, tmp_path: Path) -> None:
    looks = list(diagnosed.quality.trials)
    assert looks[1].phase is not None
    looks[1] = replace(looks[1], phase=replace(looks[1].phase, cut_off=looks[1].phase.peak_force))
    measured = {name: held.measured_peak.copy() for name, held in diagnosed.held.items()}
    for peaks in measured.values():
        peaks[diagnosed.observations.condition == diagnosed.observations.condition[0]] = np.nan
    cut = replace(
        diagnosed,
        quality=replace(diagnosed.quality, trials=tuple(looks)),
        held={name: replace(held, measured_peak=measured[name]) for name, held in diagnosed.held.items()},
    )
    text = read(cut, tmp_path).text.replace("\u00a0", " ")
    assert f"≥ {looks[1].phase.peak_force:.1f} N" in text and "cut off" in text


def test_the_report_allows_no_speed(diagnosed: Diagnosis) -> None:
    """Half of all peaks are above the expected one: a speed with a margin is what `speed` is for."""

    def peaks(*forces: float) -> list[SimpleNamespace]:
        return [
            SimpleNamespace(contact_peak_force=f, contact_peak_force_std=1.0, peak_force=f) for f in forces
        ]

    models = {"nominal": peaks(100.0, 123.89), "corrected": peaks(100.0, 200.0)}
    look = SimpleNamespace(curves=(SimpleNamespace(f_p=80.0, v_e=np.array([1.0, 2.0]), by_model=models),))
    said = consequence(diagnosed, look)
    assert (
        "reaches 124 N at 1.2 m/s already. That has no margin: the command speed tells" in said
        and "at no more than" not in said
    )
    models["corrected"] = peaks(90.0, 100.0)
    assert "already" not in consequence(diagnosed, look)  # what was tried says nothing of faster ones


def test_an_unknown_cause_is_drawn_along_the_impacts(unknown: Diagnosis, tmp_path: Path) -> None:
    figure = read(unknown, tmp_path).figures["unknown-data"]
    assert [v["layout"]["xaxis"]["title"]["text"].split(" / ")[0] for v in figure["variants"]] == [
        "stroke",
        "speed of the flange",
        "time",
    ]
    assert all(len(v["data"]) > 1 for v in figure["variants"])


@pytest.mark.parametrize(
    ("curve", "strengths"),
    [
        ("unknown_actuator", {"dry_n": 10.0}),
        ("unknown_actuator", {"held_share": 0.5}),
        ("unknown_contact", {"step_100_n": 10.0, "pad_kg": 0.5}),
        ("unknown_robot", {}),
    ],
)
def test_the_drawn_impact_obeys_the_contact_law(curve: str, strengths: dict[str, float]) -> None:
    """F_C = k_C s + F_C(0) and what the contact adds; the force is that of the fit, which is simulated apart."""
    values = [strengths.get(p.name, p.scale if p.shape else 0.0) for p in every_effect()[curve].parameters()]
    theta = np.array([2.0, 60.0, 2e3, 1.5e5, *values])
    v_e, f_p, grid = np.array([0.3]), np.array([80.0]), Grid(5e-5, 300)
    (course,) = along(
        SimpleNamespace(explanation=(curve,), physical=theta, grid=grid), v_e, f_p, np.array([0.01])
    )
    added = course.discrepancy if curve == "unknown_contact" else 0.0
    law = 1.5e5 * 1e-3 * course.compression + course.force[0] + added
    np.testing.assert_allclose(course.force, law, atol=1e-6)
    contact = forward((curve,), theta, v_e, f_p, grid).contact[0]
    np.testing.assert_allclose(
        course.force, np.interp(course.time, 0.05 * np.arange(301), contact), rtol=1e-9
    )
    lag = 0.3 * course.time - course.stroke - course.compression
    assert (np.abs(lag).max() > 0.1) == ("pad_kg" in strengths), "the pad moves in addition to the flange"
    if "held_share" in strengths:
        still = course.time < course.time[np.argmax(course.force > 80.0)]
        assert course.force[0] == pytest.approx(40.0) and still.sum() > 3 and not course.stroke[still].any()


def test_numbers_in_words() -> None:
    assert percent(0.9996) == percent(1.0) == "> 99 %" and percent(1e-9) == "< 1 %" and percent(0.5) == "50 %"
    assert percent(-0.26) == "−26 %" and percent(0.031, signed=True) == "+3 %" and percent(None) == "–"
    assert (
        si(-540.0, 2) == "−540"
        and si(217634.0) == "217\u202f600"
        and si(2.5e-7, 2, "N s/m") == ("2.5·10⁻⁷\u00a0N\u00a0s/m")
    )
    assert _range([11.01, 11.04], "N") == "11\u00a0N" and _range([-1.0, 2.0], "N") == "−1 to 2\u00a0N"
    assert of_removed(0.4, 0.96) == "95 % interval 40 % to 96 %"
    assert of_removed(-14.28, 0.96) == "95 % interval up to 96 %; it may also grow"
    assert listed(["a", "b", "c"], "or") == "a, b or c" and listed([]) == ""
    assert headed("k_1 / k_C") == "k_1 / k_C" and headed("mass") == "Mass"
    assert formula("omega_s^2 < k_C") == "ω<sub>s</sub><sup>2</sup> &lt; k<sub>C</sub>"
    assert formula("moving_mass_kg") == "moving_mass_kg"

"""The command `run`: from a recording to allowed speeds on one page, and where it stops."""

import json
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from acf_jax import diagnosis as library
from acf_jax import pipeline
from acf_jax.cli.main import main
from acf_jax.designs.asked import Asked
from acf_jax.designs.speed import find_speeds
from acf_jax.errors import InputError
from tests.few import few_explanations

EXAMPLES = Path(__file__).parents[2] / "examples"
RIG = EXAMPLES / "session_rig.yaml"
EVIL = "<b>'&.csv"


@pytest.fixture
def run(monkeypatch, capsys):
    """Exit code, standard output and standard error of `run`."""
    monkeypatch.setattr("acf_jax.start.start_jax", lambda: None)  # tests set JAX themselves

    def call(*arguments: object) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as end, few_explanations(("end_stop",), ()):
            main(["run", *map(str, arguments)])
        return end.value.code, *capsys.readouterr()

    return call


def files(folder: Path) -> list[str]:
    return sorted(str(f.relative_to(folder)) for f in folder.rglob("*") if f.is_file())


def recording(folder: Path, contacts: int) -> Path:
    """So many half sines of 100 N at 0.2 m/s, under a name that is no HTML."""
    time = np.arange(0.0, 0.5 * contacts + 0.5, 2e-4)
    phase = (time % 0.5 - 0.25) / 0.01
    force = np.where((phase > 0) & (phase < 1) & (time < 0.5 * contacts), 100 * np.sin(np.pi * phase), 0.0)
    force += 0.05 * np.random.default_rng(0).standard_normal(time.size)
    rows = [f"{t:.4f},{f:.4f},0.2,60" for t, f in zip(time, force, strict=True)]
    path = folder / EVIL
    path.write_text("\n".join(["time_s,force_n,velocity_m_per_s,pretension_n", *rows, ""]))
    return path


def test_from_a_recording_to_speeds_and_a_contact(run, tmp_path):
    out = tmp_path / "result"
    asked = ("--rig", RIG, "--limit", 140, "--out", out, "--area", "palm", "--stop-after", 0.05)
    code, text, error = run(EXAMPLES / "session.mcap", *asked)
    assert code == 1 and not error  # the contact is not allowed
    page = (out / "index.html").read_text()
    head, sections = page.split("<main", 1)
    assert (
        "Identified: </span>end stop" in head
        and "On the machine: move the working point off the stop" in head
    )
    for link in ("data/import.html", "diagnosis/report.html"):
        assert f'href="{link}"' in sections and (out / link).is_file()
    assert (
        head.index("Identified") < head.index("On the machine") and "Highest velocity within 140" in sections
    )

    from acf_jax.contact.model_file import ModelFile  # the same speeds as by `speed`

    model = ModelFile(out / "diagnosis").load()
    speeds = {f_p: find_speeds(model, Asked(f_p, (140.0,))).found[0] for f_p in (50.0, 90.0)}
    for f_p, found in speeds.items():
        shown = f"{np.floor(1e4 * found.z[-2]) / 1e4:.4f} m/s"
        assert re.search(rf"\n +{f_p:g} N +{re.escape(shown)} ", text)
        assert re.search(rf"{f_p:g}\xa0N</th>.*?{shown.replace(' ', chr(0xA0))}", sections)
    assert 0.2 < speeds[90.0].z[-2] < speeds[50.0].z[-2] < 0.35
    # at the fastest trial, with the highest pretension tried with it
    assert re.search(r"Not allowed: Palm .*, quasi-static contact at 0\.349\d* m/s with 90 N", text)
    assert "Not allowed: Palm" in sections and "highest velocity allowed here" in sections


def stopping(monkeypatch, **changes: object) -> None:
    """Diagnoses end with these fields."""
    real = library.diagnose

    def diagnose(*arguments, **options):
        return replace(real(*arguments, **options), **changes)

    monkeypatch.setattr(library, "diagnose", diagnose)


def test_too_little_data_stop_it_before_speeds(run, monkeypatch, tmp_path):
    out = tmp_path / "result"
    stopping(monkeypatch, verdict="insufficient_data", next_experiment=None)
    code, text, error = run(EXAMPLES / "session.mcap", "--rig", RIG, "--limit", 140, "--out", out, "--json")
    told = json.loads(text)
    assert code == 1 and told["verdict"] == "insufficient_data" and told["speeds"] == [] and not told["check"]
    (reason,) = told["stopped"]
    assert error == f"no answer: {reason}\n"
    assert "diagnosis/model.json: the diagnosis had too little data to answer: its trials" in reason
    page = (out / "index.html").read_text()
    assert "Insufficient data: </span>" in page and "then diagnose again" in page
    assert "Highest velocity" not in page and (out / "diagnosis/report.html").is_file()


def test_a_refused_import_says_so_and_leaves_no_earlier_result(run, tmp_path):
    out = tmp_path / "result"
    earlier = out / "diagnosis/report.html"
    earlier.parent.mkdir(parents=True)
    earlier.write_text("of an earlier run, by acf-jax")
    (out / "notes.txt").write_text("mine")
    code, text, error = run(recording(tmp_path, 2), "--rig", RIG, "--limit", 140, "--out", out)
    assert code == 1 and error.startswith("no answer: ") and "2 contacts" in text
    assert files(out) == ["data/import.html", "index.html", "notes.txt"]
    page = (out / "index.html").read_text()
    assert "No diagnosis: </span>" in page and "Why the run went no further" in page
    assert "<b>" not in page and "&lt;b&gt;" in page and "report.html" not in page


def test_trials_that_cannot_be_used_stop_it(run, monkeypatch, tmp_path):
    def diagnose(*arguments, **options):
        raise InputError("only 2 trials can be used")

    monkeypatch.setattr(library, "diagnose", diagnose)
    out = tmp_path / "result"
    code, _, error = run(EXAMPLES / "session.mcap", "--rig", RIG, "--limit", 140, "--out", out)
    assert code == 1 and error == "no answer: only 2 trials can be used\n"
    assert "only 2 trials can be used" in (out / "index.html").read_text()
    assert (out / "data/trials.csv").is_file() and not (out / "diagnosis").exists()


def test_a_contact_that_no_check_takes_is_a_stated_reason(run, monkeypatch, tmp_path):
    """The diagnosis and the speeds that were found stay."""
    out = tmp_path / "result"
    real = pipeline.check_fastest

    def check_fastest(model, question, tried):
        return real(model, question, SimpleNamespace(v_e=tried.v_e, f_p=0.0 * tried.f_p + 0.4))

    monkeypatch.setattr(pipeline, "check_fastest", check_fastest)
    asked = ("--limit", 140, "--area", "palm", "--out", out)
    code, text, error = run(EXAMPLES / "session.mcap", "--rig", RIG, *asked)
    reason = (
        "no check of the contact at the fastest speed that was tried: f_p must be at least 1 N, but is 0.4"
    )
    assert code == 1 and reason in error and "Highest velocity within 140 N" in text
    assert (
        reason.split(":")[0] in (out / "index.html").read_text() and (out / "diagnosis/report.html").is_file()
    )


@pytest.mark.parametrize("arguments, says", [
    (["--limit", 0.1], "--limit must be at least 1 N, but is 0.1"),
    (["--limit", 140, "--area", "nose"], "--area 'nose'"),
    (["--limit", 140, "--stop-after", 0.05], "--stop-after belongs to --area"),
    (["--limit", 140, "--area", "palm", "--travel", 40], "--travel must be at most 2 m"),
    (["--limit", 140, "--force", ""], "--force"),
])  # fmt: skip
def test_faults_are_told_before_anything_is_read(run, tmp_path, arguments, says):
    out = tmp_path / "result"
    code, text, error = run(tmp_path / "none.csv", "--rig", tmp_path / "none.yaml", *arguments, "--out", out)
    assert code == 2 and not text and not out.exists()
    assert says in error and "none.yaml: no such file" in error and "none.csv" not in error


def test_a_data_set_of_others_is_not_replaced(run, tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "data/trials.csv").write_text("mine")
    code, _, error = run(EXAMPLES / "session.mcap", "--rig", RIG, "--limit", 140, "--out", tmp_path)
    assert code == 2 and "holds a data set that no import wrote" in error
    assert files(tmp_path) == ["data/trials.csv"]

"""A small fixed blind run from the first draw to the score, as the command line does it."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from needs import need_module

from acf_jax.cli.main import commands
from acf_jax.errors import InputError
from acf_jax.gap_model import read_model
from acf_jax.workers import Lost, Where, run_all
from validation.blind import campaign
from validation.blind.plan import Order

CASES = "3"
ROOT = Path(__file__).parents[3]
SCHEDULER = """
import sys, time
from distributed import LocalCluster
options = {"processes": False, "protocol": "tcp", "dashboard_address": None, "memory_limit": 0}
with LocalCluster(n_workers=1, threads_per_worker=1, **options) as cluster:
    print(cluster.scheduler_address, flush=True)
    sys.stdin.read()
"""


def blind(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "acf_jax", "blind", *arguments],
        capture_output=True, text=True, check=True, env={**os.environ, "PYTHONWARNINGS": "default"},
    )  # fmt: skip


def refused(*arguments):
    CliRunner().invoke(commands, ["blind", *arguments], catch_exceptions=False)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    need_module("distributed", "pip install '.[fleet]'")
    out = tmp_path_factory.mktemp("blind") / "run"
    arguments = ["--out", str(out), "--seed", "17", "--cases", CASES, "--world", "scipy", "--workers", "1"]
    return out, arguments, blind(*arguments).stdout


@pytest.mark.long
def test_every_answer_is_given_before_the_seal_is_opened(run):
    out, _, printed = run
    seal = json.loads((out / "sets" / "seal.json").read_text())
    assert f"answers sealed, SHA-256 {seal['sha256']}" in printed
    opened = json.loads((out / "results" / "opened.json").read_text())
    answers = sorted((out / "results").glob("case-*/diagnosis.json"))
    assert len(answers) == int(CASES)
    assert all(seal["sealed_at"] < file.stat().st_mtime < opened["opened_at"] for file in answers)
    assert not list((out / "sets").rglob("answer*.yaml"))


@pytest.mark.long
def test_the_score_is_better_than_chance_and_complete(run):
    out, _, printed = run
    content = json.loads((out / "results" / "score.json").read_text())
    rows = content["rows"]
    assert len(rows) == int(CASES) and not content["score"]["errors"]
    # fourteen explanations: a guess would be right once in five such runs
    assert sum(row["first_in_class"] for row in rows) >= 2
    assert "false alarms without any effect" in printed
    page = (out / "results" / "score.html").read_text()
    assert "Confusion matrix" in page
    made = json.loads((out / "results" / "provenance.json").read_text())
    assert made["made_of"][0]["sha256"][:12] in page.split("<footer>")[1]
    head = page.split("<script>")[0]
    assert f"; {page.count('>met</span>')} of " in head
    assert "src=" not in head and "<link" not in head  # nothing comes from elsewhere


@pytest.mark.long
def test_a_finished_run_is_scored_again_without_work(run):
    out, arguments, _ = run
    before = {f: f.stat().st_mtime for f in (out / "results").glob("case-*/*.json")}
    assert json.loads(blind(*arguments, "--json").stdout) == json.loads(
        (out / "results/score.json").read_text()
    )
    assert {f: f.stat().st_mtime for f in before} == before


@pytest.mark.long
def test_a_damaged_diagnosis_is_refused_before_the_answers_are_opened(run, tmp_path):
    """So that it can be made again; and one of a data set that cannot be used stands on the page."""
    shutil.copytree(run[0], tmp_path / "run")
    results = tmp_path / "run" / "results"
    (results / "opened.json").unlink()
    file = results / "case-000" / "diagnosis.json"
    file.write_text("{")
    score = ("score", str(tmp_path / "run" / "sets"), "--out", str(results), "--workers", "1")
    with pytest.raises(InputError, match=r"case-000.diagnosis\.json: .*diagnose again"):
        refused(*score)
    assert not (results / "opened.json").exists()
    file.write_text('{"error": "trials.csv: <b>no rows</b>"}')
    refused(*score)
    assert "trials.csv: &lt;b&gt;no rows&lt;/b&gt;" in (results / "score.html").read_text()


@pytest.mark.long
def test_data_changed_after_their_diagnosis_are_refused(run, tmp_path):
    """Neither an old diagnosis of other data nor the old fault of mended ones is scored."""
    shutil.copytree(run[0], tmp_path / "run")
    sets, results = tmp_path / "run" / "sets", tmp_path / "run" / "results"
    score = ("score", str(sets), "--out", str(results), "--workers", "1")
    table = sets / "case-001" / "trials.csv"
    whole = table.read_text()
    table.write_text("\n".join(whole.splitlines()[:-1]) + "\n")
    with pytest.raises(InputError, match=r"case-001: was changed after its diagnosis; .*start another one"):
        refused(*score)
    (results / "opened.json").unlink()
    with pytest.raises(InputError, match=r"case-001: was changed after its diagnosis; remove .*case-001"):
        refused(*score)
    table.write_text(whole)
    (results / "case-001" / campaign.SOURCE).write_text(campaign.UNREADABLE)
    with pytest.raises(InputError, match="case-001: was changed"):
        refused(*score)


@pytest.mark.long
def test_held_out_conditions_that_a_trial_had_are_not_scored(run, tmp_path):
    from validation.blind.score import _held_out

    data, model = tmp_path / "data", read_model(run[0] / "results" / "case-000" / "model.json")
    shutil.copytree(run[0] / "sets" / "case-000", data)
    every = _held_out(data, model)
    table = data / "held_out_conditions.csv"
    first, *others = table.read_text().splitlines()
    trial = (data / "trials.csv").read_text().splitlines()[1].split(",")
    tried = ",".join([others[0].split(",")[0], *trial[1:3]])
    table.write_text("\n".join([first, tried, *others[1:]]) + "\n")
    assert 0 < _held_out(data, model)["rms_recalibrated"] != every["rms_recalibrated"]
    table.write_text(f"{first}\n{tried}\n")
    assert _held_out(data, model) == {}


@pytest.mark.long
def test_another_run_in_the_same_folder_is_refused(run):
    out, *_ = run
    with pytest.raises(InputError, match="name another --out"):
        refused("--out", str(out), "--seed", "6", "--cases", CASES)


def test_a_folder_without_data_sets_is_refused(tmp_path):
    with pytest.raises(InputError, match="holds no data sets"):
        refused("score", str(tmp_path), "--out", str(tmp_path / "out"))


def test_machines_that_have_only_what_is_installed_draw_the_same_data(tmp_path):
    """Worlds and blind runs are no part of that: their source goes along with the work."""
    need_module("distributed", "pip install '.[fleet]'")
    order = Order("none", 5, (), None, False, "scipy")
    installed = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
    started = [sys.executable, "-c", SCHEDULER]
    with subprocess.Popen(
        started, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=tmp_path, env=installed
    ) as process:
        where = Where(process.stdout.readline().strip())
        ((name, made),) = run_all(campaign._make_one, [("a", order)], where)
        process.stdin.close()
    assert name == "a" and made == campaign._make_one(order)


def test_the_command_is_that_of_the_folder_and_works_from_anywhere(tmp_path):
    """Also where the caller has another folder of that name; of the source, which is not installed with the package."""
    (tmp_path / "validation").mkdir()
    (tmp_path / "validation/__init__.py").write_text("raise RuntimeError('not mine')")
    for module, cwd in (("acf_jax", tmp_path), ("validation.blind", ROOT)):
        words = ["blind"] * (module == "acf_jax") + ["seal", str(tmp_path)]
        finished = subprocess.run(
            [sys.executable, "-m", module, *words],
            cwd=cwd,
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "PYTHONPATH": str(ROOT / "src")},
        )
        assert finished.returncode == 2
        assert (
            finished.stderr == f"error: {tmp_path}: no answers to seal; each data set needs an answer.yaml\n"
        )


def test_a_data_set_that_fails_is_named_when_the_others_are_done(monkeypatch):
    kept = []
    outcomes = [("a", Lost("4 processes died of it")), ("b", 2), ("c", ValueError("no"))]
    monkeypatch.setattr(campaign, "run_all", lambda *given: iter(outcomes))
    with pytest.raises(InputError) as error:
        campaign._each(abs, [], lambda *done: kept.append(done), Where(), lambda *told: None, 0, 3)
    assert kept == [("b", 2)]
    assert error.value.faults == [
        "a: failed (Lost: 4 processes died of it); the same command goes on where it was",
        "c: failed (ValueError: no); the same command goes on where it was",
    ]

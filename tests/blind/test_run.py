"""A small fixed blind run from the first draw to the score, as the command line does it."""

import json
import os
import subprocess
import sys

import pytest
from click.testing import CliRunner
from needs import need_module

from acf_jax.blind import campaign
from acf_jax.cli.main import commands
from acf_jax.errors import InputError
from acf_jax.workers import Lost, Where

CASES = "3"


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


def test_every_answer_is_given_before_the_seal_is_opened(run):
    out, _, printed = run
    seal = json.loads((out / "sets" / "seal.json").read_text())
    assert f"answers sealed, SHA-256 {seal['sha256']}" in printed
    opened = json.loads((out / "results" / "opened.json").read_text())
    answers = sorted((out / "results").glob("case-*/diagnosis.json"))
    assert len(answers) == int(CASES)
    assert all(seal["sealed_at"] < file.stat().st_mtime < opened["opened_at"] for file in answers)
    assert not list((out / "sets").rglob("answer*.yaml"))


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
    head = page.split("<script>")[0]
    assert "src=" not in head and "<link" not in head  # nothing comes from elsewhere


def test_a_finished_run_is_scored_again_without_work(run):
    out, arguments, _ = run
    before = {f: f.stat().st_mtime for f in (out / "results").glob("case-*/*.json")}
    assert json.loads(blind(*arguments, "--json").stdout) == json.loads(
        (out / "results/score.json").read_text()
    )
    assert {f: f.stat().st_mtime for f in before} == before


def test_another_run_in_the_same_folder_is_refused(run):
    out, *_ = run
    with pytest.raises(InputError, match="name another --out"):
        refused("--out", str(out), "--seed", "6", "--cases", CASES)


def test_a_folder_without_data_sets_is_refused(tmp_path):
    with pytest.raises(InputError, match="holds no data sets"):
        refused("score", str(tmp_path), "--out", str(tmp_path / "out"))


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

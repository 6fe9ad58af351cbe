"""Progress for a program, and what `diagnose` is told that cannot be the cause."""

import io
import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from acf_jax.cli._progress import counts, stages
from acf_jax.cli.main import commands
from acf_jax.training.progress import progress

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def test_each_step_is_a_line_where_a_program_asks(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def work() -> list[tuple[str, int, int]]:
        with stages() as stage, counts() as count, progress("training", 0, 1000) as told:
            stage("looking")
            count("reading", 3, 8)
            for step in range(0, 1001):
                told(step, 0.1)
        out, err = capsys.readouterr()
        assert out == ""
        return [(line["stage"], line["done"], line["total"]) for line in map(json.loads, err.splitlines())]

    monkeypatch.delenv("ACF_JAX_PROGRESS", raising=False)
    assert work() == []  # in a pipe
    monkeypatch.setenv("ACF_JAX_PROGRESS", "json")
    lines = work()
    assert lines[:2] == [("looking", 0, 0), ("reading", 3, 8)]
    assert lines[2:] == [("training", step, 1000) for step in range(0, 1001, 10)]


def test_a_note_stands_beside_the_stage_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.delenv("ACF_JAX_PROGRESS", raising=False)
    monkeypatch.setattr("sys.stderr", terminal := Terminal())
    with stages("(the first time only)") as stage:
        stage("fitting")
    assert "fitting (the first time only)" in terminal.getvalue()


@pytest.mark.parametrize("name, told", [("endstop", "end_stop"), ("nothing", "take of")])
def test_a_cause_that_there_is_not_cannot_be_left_out(tmp_path: Path, name: str, told: str) -> None:
    command = ["diagnose", str(EXAMPLES / "rig"), "--out", str(tmp_path / "out"), "--without", name]
    found = CliRunner().invoke(commands, command)
    assert told in str(found.exception) and f"--without: no effect is called '{name}'" in str(found.exception)
    assert not (tmp_path / "out").exists()


def test_without_the_extra_the_app_says_how_to_install_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "uvicorn", None)
    found = CliRunner().invoke(commands, ["app", str(tmp_path)])
    assert "pip install 'acf-jax[app]'" in str(found.exception)
    found = CliRunner().invoke(commands, ["app", str(tmp_path / "none")])
    assert "is no folder" in str(found.exception)


def test_a_port_that_is_taken_is_told(tmp_path: Path) -> None:
    import socket

    pytest.importorskip("uvicorn")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        found = CliRunner().invoke(commands, ["app", str(tmp_path), "--no-browser", "--port", port])
    assert f"--port {port}: cannot be had" in str(found.exception)

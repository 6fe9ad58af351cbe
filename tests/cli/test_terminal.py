"""What a shell and a terminal see: completion, version, colours, Ctrl-C; and `python -m train.fit` alike."""

import gc
import json
import os
import pty
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from acf_jax import __version__
from acf_jax.cli._ending import end_well
from acf_jax.cli.main import COMPLETE, main
from tests.needs import need_program
from train import fit

ROOT = Path(__file__).resolve().parents[2]
CONFIG = str(ROOT / "configs/table1.yaml")
COLOUR = re.compile(r"\x1b\[[0-9;]*3[0-9][0-9;]*m")


@pytest.mark.parametrize(
    "shell, begins",
    [("bash", "_acf_jax_completion()"), ("zsh", "#compdef acf-jax"), ("fish", "function _acf_jax")],
)
def test_completion_scripts(shell, begins, monkeypatch, capsys):
    if shell == "bash":
        need_program("bash")  # click asks it for its version
    monkeypatch.setenv(COMPLETE, f"{shell}_source")
    with pytest.raises(SystemExit) as caught:
        main([])
    text = capsys.readouterr().out
    assert caught.value.code == 0 and text.startswith(begins) and f"{COMPLETE}={shell}_complete" in text


@pytest.mark.parametrize(
    "words, offered", [("acf-jax blind s", {"score", "seal"}), ("acf-jax peak --k", {"--k-f", "--k-c"})]
)
def test_completion_offers_commands_and_options(words, offered, monkeypatch, capsys):
    monkeypatch.setenv(COMPLETE, "bash_complete")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(words.count(" ")))
    with pytest.raises(SystemExit):
        main([])
    assert {line.partition(",")[2] for line in capsys.readouterr().out.split()} == offered


@pytest.mark.parametrize("program", [main, fit.main])
def test_version(program, capsys):
    with pytest.raises(SystemExit) as caught:
        program(["--version"])
    assert caught.value.code == 0 and capsys.readouterr().out.split()[-1] == __version__


def test_no_color_leaves_colours_out():
    coloured, plain = on_terminal({}), on_terminal({"NO_COLOR": "1"})
    assert COLOUR.search(coloured) and not COLOUR.search(plain)
    assert all("things" in text and "loss 5.0e-01" in text for text in (coloured, plain))


def on_terminal(environment: dict[str, str]) -> str:
    """What a terminal gets from the bars, on standard error."""
    code = (
        "from acf_jax.cli._progress import counted; list(counted(range(3), 'things'))\n"
        "from acf_jax.training.progress import progress\nwith progress('fold', 0, 2) as told: told(1, 0.5)"
    )
    terminal, end = pty.openpty()
    variables = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "FORCE_COLOR")}
    variables |= {"TERM": "xterm-256color", **environment}
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, env=variables, stderr=end, check=True)
    return os.read(terminal, 100_000).decode()


def test_ctrl_c_while_a_diagnosis_runs(tmp_path):
    command = [sys.executable, "-m", "acf_jax", "diagnose", "examples/rig", "--out", str(tmp_path / "out")]
    terminal, end = pty.openpty()
    environment = {**os.environ, "TERM": "xterm"}
    process = subprocess.Popen(command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, stderr=end)
    os.close(end)
    os.read(terminal, 100)  # the spinner is there: it computes
    process.send_signal(signal.SIGINT)
    told = b""
    while b"half-written" not in told:
        told += os.read(terminal, 10_000)
    printed, _ = process.communicate()
    os.close(terminal)
    assert process.returncode == 130 and not printed
    assert b"stopped; nothing is left half-written" in told and b"Traceback" not in told
    assert not list(tmp_path.iterdir())


def test_ctrl_c_in_a_callback_of_the_garbage_collector_counts(capsys):
    def interrupt(*_):
        gc.callbacks.remove(interrupt)
        signal.raise_signal(signal.SIGINT)

    def work():
        gc.callbacks.append(interrupt)
        gc.collect()
        for _ in range(200):  # a signal that is only noted ends no sleep
            time.sleep(0.05)

    before = sys.unraisablehook
    assert end_well(work) == 130 and sys.unraisablehook is before
    assert capsys.readouterr().err == "\nstopped; nothing is left half-written\n"


def test_training_ends_as_every_command_does(monkeypatch, capsys, tmp_path):
    assert fit.main(["--config", str(tmp_path / "none.yaml")]) == 2
    assert capsys.readouterr().err == f"error: {tmp_path / 'none.yaml'}: no such file; check the path\n"
    with pytest.raises(SystemExit) as caught:
        fit.main(["--config", CONFIG, "--resum"])
    assert caught.value.code == 2 and "--resum" in capsys.readouterr().err

    def stop(*arguments: object, origin: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("acf_jax.training.run.run", stop)
    assert fit.main(["--config", CONFIG]) == 130
    assert capsys.readouterr().err == "\nstopped; --resume goes on from the last checkpoint\n"

    monkeypatch.setattr(
        "acf_jax.training.run.run", lambda *arguments, origin: print("words") or {"errors": 1}
    )
    assert fit.main(["--config", CONFIG, "--json"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out) == {"errors": 1} and err == "words\n"

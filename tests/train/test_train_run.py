"""A run: same seed, same metrics; killed and resumed, same metrics; a loss that diverges stops it."""

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from acf_jax.surrogate import load_surrogate
from acf_jax.surrogate.saved import read_header
from acf_jax.training import checkpoint, evaluate, loop, paper
from acf_jax.training.checkpoint import State
from acf_jax.training.config import read_config
from acf_jax.training.data import make_data
from acf_jax.training.paper import bound_error
from tests.needs import need_chromium
from train import fit

REPOSITORY = Path(__file__).parents[2]


def _command(config: Path, folder: Path) -> list[str]:
    return [sys.executable, "-m", "train.fit", "--config", str(config), "--set", f"output={folder}"]


def test_writes_what_it_promises(finished: Path) -> None:
    names = {path.name for path in finished.iterdir()}
    assert {"metrics.json", "timings.json", "report.html", "model.eqx", "config.yaml"} <= names
    made = json.loads((finished / "provenance.json").read_text())
    assert made["command"].startswith("python -m train.fit --config ") and len(made["made_of"]) == 1
    assert (
        made["command"].split(" --config")[0] in (finished / "report.html").read_text().split("<footer>")[1]
    )
    metrics = json.loads((finished / "metrics.json").read_text())
    assert set(metrics["errors"]) == {"fold", "dimensionless"}
    for error in metrics["errors"].values():
        relative = error["box"]["relative"]
        assert 0 < relative["median"] < relative["p99"] < relative["p99_9"] < relative["max"] < 0.5
        assert relative["largest_under_prediction"] <= relative["max"]
    counts = metrics["samples"]["box"]
    assert counts["with_peak"] + counts["without_peak"] == 4096
    # about 17 % of the wide box
    assert 0.12 < counts["without_peak"] / 4096 < 0.22
    assert len(metrics["worst"]) == 10
    for row, of_paper in zip(metrics["table1"], (108, 130, 195, 271, 310), strict=True):
        assert abs(row["model"] - of_paper) <= 0.5
        assert abs(row["surrogate"] - row["model"]) < 1


@pytest.mark.long
def test_killed_and_resumed_gives_the_same_metrics(
    small: Path, finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """SIGKILL once a few checkpoints were written, wherever the process then is."""
    process = subprocess.Popen(
        _command(small, tmp_path), cwd=REPOSITORY, stdout=subprocess.DEVNULL, env=_environment()
    )
    path = tmp_path / "checkpoints" / "fold.eqx"
    seen: set[int] = set()
    while len(seen) < 4 and process.poll() is None:
        if path.exists():
            seen.add(path.stat().st_mtime_ns)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    assert path.exists() and not (tmp_path / "metrics.json").exists()
    # what a kill in the middle of the next write leaves behind
    path.with_name(".fold.eqx.partial").write_bytes(path.read_bytes()[:-100])

    killed_at, saved_at = read_header(path)[0]["step"], []

    def save_state(path: Path, state: State, identity: dict[str, Any]) -> None:
        saved_at.append(state.step)
        checkpoint.save_state(path, state, identity)

    monkeypatch.setattr(loop, "save_state", save_state)

    assert fit.main(["--config", str(small), "--resume", "--set", f"output={tmp_path}"]) == 0
    assert saved_at[0] == (killed_at + 20 if killed_at < 400 else 20), "must go on where the killed run was"
    assert (tmp_path / "metrics.json").read_bytes() == (finished / "metrics.json").read_bytes()


def test_resuming_a_finished_run_changes_nothing(small: Path, finished: Path) -> None:
    before = (finished / "metrics.json").read_bytes()
    assert fit.main(["--config", str(small), "--resume", "--set", f"output={finished}"]) == 0
    assert (finished / "metrics.json").read_bytes() == before


def test_checkpoint_of_another_configuration_is_refused(
    small: Path, finished: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--config", str(small), "--resume", "--set", f"output={finished}", "--set", "seed=4"]
    assert fit.main(arguments) == 2
    assert "was written with another configuration" in capsys.readouterr().err


def test_a_new_run_leaves_no_checkpoint_of_an_earlier_one(
    small: Path,
    finished: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    shutil.copytree(finished, tmp_path / "run")
    arguments = ["--config", str(small), "--set", f"output={tmp_path / 'run'}", "--set", "seed=4"]
    said = f"resume with that one, {tmp_path / 'run' / 'config.yaml'}"
    assert fit.main([*arguments, "--resume"]) == 2 and said in capsys.readouterr().err
    assert read_config(tmp_path / "run" / "config.yaml").seed == 3

    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(paper, "train_network", stopped)
    assert fit.main(arguments) == 130
    assert not (tmp_path / "run" / "checkpoints").exists()
    assert read_config(tmp_path / "run" / "config.yaml").seed == 4


def test_ranges_without_a_peak_are_refused(
    small: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--config", str(small), "--set", f"output={tmp_path}"]
    for change in ("zeta.low=1.4", "f_p.high=1e-6", "k_c.high=1.1e4", "k_f.low=9e3"):
        arguments += ["--set", f"ranges.{change}"]
    assert fit.main(arguments) == 2
    said = capsys.readouterr().err
    assert "ranges: of the 4,096 samples for `train` 0 have a peak, and at least 100 must" in said
    for purpose in ("held_out", "held_out_edges", "test", "test_edges"):
        assert f"`{purpose}` 0 have a peak" in said


def test_the_bound_is_a_share_of_the_surrogates_own_force(
    finished: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Half of the force is wrong by all of itself; a force a quarter too high by a fifth of itself."""
    answers = evaluate.Answers(np.array([-0.5, 0.25]), np.zeros(2), np.array([0.05, 0.95]))
    monkeypatch.setattr(evaluate, "ask", lambda *_: answers)
    bounded = bound_error(
        load_surrogate(finished / "model.eqx"), make_data(read_config(finished / "config.yaml"), "test")
    )
    assert np.allclose(bounded.held_out.largest, [1.0, *[0.2] * 9])


def test_damaged_checkpoint_is_refused(
    small: Path, tmp_path: Path, finished: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = (finished / "checkpoints" / "fold.eqx").read_bytes()
    path = tmp_path / "checkpoints" / "fold.eqx"
    path.parent.mkdir()
    path.write_bytes(whole[:-100])
    assert fit.main(["--config", str(small), "--resume", "--set", f"output={tmp_path}"]) == 2
    assert "cut off or damaged" in capsys.readouterr().err


def test_loss_that_diverges_stops_the_run_and_keeps_the_last_good_state(
    small: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A learning rate that grows through the warm-up: fine at first, beyond all numbers later."""
    changes = ("optimiser.learning_rate=1e38", "optimiser.warm_up_steps=399", "network.activation=softplus")
    arguments = ["--config", str(small), "--set", f"output={tmp_path}"]
    for change in changes:
        arguments += ["--set", change]
    assert fit.main(arguments) == 1
    shown = capsys.readouterr().err
    assert "the loss is not finite between steps" in shown
    assert "Lower optimiser.learning_rate" in shown
    assert not (tmp_path / "metrics.json").exists()


def test_report_stands_alone_and_fits_a_phone(finished: Path) -> None:
    from playwright.sync_api import sync_playwright

    text = (finished / "report.html").read_text(encoding="utf-8")
    assert "http" not in text.replace("http-equiv", ""), "a report must not load anything"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=need_chromium(), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 360, "height": 800}, color_scheme="dark")
        problems: list[str] = []
        page.on("console", lambda message: problems.append(message.text))
        page.on("pageerror", lambda error: problems.append(str(error)))
        page.goto(finished.joinpath("report.html").as_uri())
        assert page.evaluate("document.documentElement.scrollWidth") <= 360
        assert page.locator("svg").count() == 7
        assert page.locator("svg").first.bounding_box()["width"] > 300
        browser.close()
    assert problems == []


def _environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(REPOSITORY / "src"), str(REPOSITORY)])}

"""The robot's measured velocity over each cut of a recording goes into the data set."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from sessions import RIG

from acf_jax.cli.main import commands
from acf_jax.dataset import read_dataset
from tests.dataset.impacts import contact_force

APART, NOISE = 0.5, 1e-3  # s, m/s
SPEEDS = (0.1, 0.1, 0.2, 0.2, 0.3, 0.3)
CONTACTS = APART * (1.0 + np.arange(len(SPEEDS))) + 1e-4


def approach(t: np.ndarray, v: float) -> np.ndarray:
    """Steady until 3 ms after contact, then braked with 5 m/s^2 to half the speed."""
    return np.maximum(v - 5.0 * np.maximum(t - 3e-3, 0.0), 0.5 * v) * (t > -0.1) * (t < 0.1)


def recorded(path: Path, rate: float, kind: str = "velocity") -> Path:
    """A force at 8 kHz and the robot at its own rate, as arrays."""
    end, rng = APART * (len(SPEEDS) + 1), np.random.default_rng(3)
    t, beats = np.arange(0, end, 1 / 8e3), np.arange(0, end, 1 / rate)
    force, velocity = rng.normal(0.0, 0.5, t.size), np.zeros(beats.size)
    for begin, v in zip(CONTACTS, SPEEDS, strict=True):
        force += contact_force(t - begin, v, 60.0) * (t < begin + 0.02)
        velocity += approach(beats - begin, v)
    signal = velocity + rng.normal(0.0, NOISE, beats.size)
    if kind == "commanded":
        signal = np.round(
            np.where(velocity > 0, np.repeat(SPEEDS, 1 + beats.size // 6)[: beats.size], 0.0), 3
        )
    elif kind == "position":
        signal = np.cumsum(velocity) / rate
    np.savez(path, t=t, f=force, r=beats, v=signal)
    return path


def imported(folder: Path, rate: float = 500.0, kind: str = "velocity") -> str:
    recording = recorded(folder / "log.npz", rate, kind)
    speed = "position" if kind == "position" else "velocity"
    mapping = {"force": "f", "time": "t", speed: {"name": "v", "time": "r"}, "pretension": 60.0}
    (folder / "map.yaml").write_text(yaml.safe_dump(mapping))
    (folder / "rig.yaml").write_text(RIG)
    words = [
        "import",
        recording,
        "--out",
        folder / "set",
        "--mapping",
        folder / "map.yaml",
        "--rig",
        folder / "rig.yaml",
    ]
    result = CliRunner().invoke(commands, [str(word) for word in words])
    assert result.exit_code == 0, result.output
    return result.output


def test_each_trial_has_the_velocities_that_were_measured_in_it(tmp_path: Path) -> None:
    assert "goes into the motion of 6 trials" in imported(tmp_path)
    dataset = read_dataset(tmp_path / "set")
    for trial, v in zip(dataset.trials, SPEEDS, strict=True):
        assert trial.motion is not None
        time = trial.motion.time
        assert np.diff(time) == pytest.approx(2e-3, abs=1e-8) and time[0] < -0.04 and time[-1] > 0.05
        # the onset is found to a sample of the force
        assert trial.motion.value == pytest.approx(approach(time, v), abs=5 * NOISE + 5.0 / 8e3)
    assert (tmp_path / "set/trials.csv").read_text().splitlines()[0].endswith(",motion")


@pytest.mark.parametrize("rate, kind", [(50.0, "velocity"), (500.0, "commanded"), (500.0, "position")])
def test_what_does_not_tell_how_the_robot_moved_is_left_out(tmp_path: Path, rate: float, kind: str) -> None:
    """Velocities farther apart than half an impact, a speed as it was told, and a position, whose noise is another."""
    assert "motion" not in imported(tmp_path, rate, kind)
    assert not (tmp_path / "set/motion").exists()
    assert all(trial.motion is None for trial in read_dataset(tmp_path / "set").trials)


def test_another_import_removes_the_motions_of_the_one_before(tmp_path: Path) -> None:
    imported(tmp_path)
    assert len(list((tmp_path / "set/motion").iterdir())) == 6
    imported(tmp_path, kind="position")
    assert not list((tmp_path / "set").glob("motion/*"))

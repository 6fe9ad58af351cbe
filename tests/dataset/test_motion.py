"""The column `motion`: what is read, and that each fault is named with file, place and remedy."""

from pathlib import Path

import numpy as np
import pytest
from impacts import write

from acf_jax.dataset import read_dataset
from acf_jax.errors import InputError

SPEED = 0.05  # m/s, of the first trial
TIME = np.arange(-20, 31) * 1e-3


def table(
    time: np.ndarray = TIME, velocity: float | np.ndarray = SPEED, column: str = "robot_velocity_m_per_s"
) -> str:
    rows = zip(time, np.broadcast_to(velocity, time.shape), strict=True)
    return "\n".join([f"time_s,{column},told_m_per_s", *(f"{t:.6f},{v:.6g},0.05" for t, v in rows), ""])


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A data set whose first trial has a motion."""
    folder = write(tmp_path / "set")
    head, first, *rest = (folder / "trials.csv").read_text().splitlines()
    rows = [head + ",motion", first + ",motion/t000.csv", *(row + "," for row in rest), ""]
    (folder / "trials.csv").write_text("\n".join(rows))
    (folder / "motion").mkdir()
    (folder / "motion/t000.csv").write_text(table())
    return folder


def test_it_is_read(folder: Path) -> None:
    velocity = SPEED + 1e-3 * np.sin(200 * TIME)
    (folder / "motion/t000.csv").write_text(table(velocity=velocity))
    path = folder / "dataset.yaml"
    path.write_text(path.read_text() + "  robot_velocity_std_m_per_s: 0.002\n")
    dataset = read_dataset(folder)
    motion = dataset.trials[0].motion
    assert motion is not None and motion.time == pytest.approx(TIME)
    assert motion.value == pytest.approx(velocity, rel=1e-5)
    assert all(trial.motion is None for trial in dataset.trials[1:])
    assert dataset.measurement.robot_velocity_std_m_per_s == 0.002
    assert "motion" not in dataset.trials[0].other


def test_it_is_a_part_of_what_a_diagnosis_takes(folder: Path) -> None:
    before = read_dataset(folder).digest
    (folder / "motion/t000.csv").write_text(table(velocity=0.051))
    assert read_dataset(folder).digest != before


@pytest.mark.parametrize("text, says", [
    (table(column="speed"), "motion/t000.csv: column 'robot_velocity_m_per_s' is missing"),
    (table().replace("0.05,0.05", "0.05,", 1).replace(",0.05,", ",fast,", 1), "is 'fast', not a number"),
    (table().replace(",0.05,", ",nan,", 1), "is 'nan', not a finite number"),
    (table(TIME[np.r_[0, 2, 1, 3:51]]), "time must increase from row to row"),
    (table(TIME[:2]), "holds 2 samples; record the whole impact"),
    ("time_s,robot_velocity_m_per_s\n", "holds no samples; record the motion again, or leave the cell `motion` empty"),
    (table(1e3 * TIME), "time_s advances by 1 s a sample, longer than an impact (about 0.0078 s)"),
    (table(TIME[TIME > 0]), "time_s runs from 0.001 to 0.03 s; give the velocity from first contact at 0, or before"),
    (table(TIME[TIME < 0.003]), "time_s runs from -0.02 to 0.002 s"),
    (table(velocity=50.0), "is 50 at first contact, but contact_velocity_m_per_s is 0.05; give it in m/s"),
    (table(velocity=-0.05), "is -0.05 at first contact, but contact_velocity_m_per_s is 0.05; give it in"),
])  # fmt: skip
def test_each_fault_names_file_and_remedy(folder: Path, text: str, says: str) -> None:
    (folder / "motion/t000.csv").write_text(text)
    with pytest.raises(InputError) as error:
        read_dataset(folder)
    assert len(error.value.faults) == 1 and says in error.value.faults[0]
    assert "motion/t000.csv" in error.value.faults[0]


@pytest.mark.parametrize("cell, says", [
    ("motion/none.csv", "none.csv: no such file"),
    ("../t000.csv", "motion '../t000.csv'"),
    ("traces/t000.csv", "motion is that of row 2 already; give each trial its own motion"),
])  # fmt: skip
def test_a_cell_names_a_file_of_its_own(folder: Path, cell: str, says: str) -> None:
    path = folder / "trials.csv"
    path.write_text(path.read_text().replace("motion/t000.csv", cell))
    with pytest.raises(InputError) as error:
        read_dataset(folder)
    assert says in "\n".join(error.value.faults)


@pytest.mark.parametrize(
    "value, says", [("2", "must be at most 0.5 m/s"), ("0", "must be at least 1e-07 m/s")]
)
def test_its_scatter_is_judged(folder: Path, value: str, says: str) -> None:
    path = folder / "dataset.yaml"
    path.write_text(path.read_text() + f"  robot_velocity_std_m_per_s: {value}\n")
    with pytest.raises(InputError) as error:
        read_dataset(folder)
    assert "robot_velocity_std_m_per_s" in error.value.faults[0] and says in error.value.faults[0]

"""Calibration of an automatic hammer: peak force against motor speed, 500 blows with a blue and 300 with a white tip.

Known: how the peak grows with the speed (power 1.3 with the blue tip, a stiffening contact; 0.9 with the white one).
Assumed: the force is in N; the tip moves with the motor's angle on a lever of 0.1 m, which only sets the scale; a mass
of 0.1 kg within a half. Peaks only.
"""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from acf_jax.dataset import Measurement, Prior, RigPrior
from acf_jax.errors import InputError
from benchmarks.measured.recorded import MeasuredSet, Recorded

STEPS, LEVER = 276, 0.1  # a turn; m
RIG = RigPrior(Prior(0.1, 0.05), Prior(0.0, 5.0), Prior(0.0, 100.0), Prior(7e4, 5e4))
MEASUREMENT = Measurement(5.0, contact_velocity_rel_std=0.01)
SLOWEST, FASTEST, BLOWS = 400.0, 2000.0, 24  # steps/s; below, the hammer hardly strikes


def sets(copy: Path) -> Iterator[MeasuredSet]:
    """One set a tip, blows evenly over the speeds."""
    for tip in ("blue", "white"):
        path = copy / "calibration" / f"AMH_{tip}tip.py"
        if not path.is_file():
            raise InputError([f"{path} is missing; copy the whole repository"])
        text = path.read_text("utf-8")
        peak, speed = (_array(text, name, path) for name in ("excitations_data", "speeds_data"))
        used = np.flatnonzero((speed >= SLOWEST) & (speed <= FASTEST))
        chosen = used[np.linspace(0, len(used) - 1, BLOWS).round().astype(int)]
        trials = tuple(
            Recorded(
                f"t{i:03d}",
                float(speed[i] / STEPS * 2 * np.pi * LEVER),
                0.0,
                np.empty(0),
                np.empty(0),
                peak=float(peak[i]),
            )
            for i in chosen.tolist()
        )
        yield MeasuredSet(f"amh_{tip}", f"peaks of an automatic hammer, {tip} tip", RIG, MEASUREMENT, trials)


def _array(text: str, name: str, path: Path) -> np.ndarray:
    """The numbers of an array that a script holds; the script is read, not run."""
    found = re.search(rf"{name} = np\.array\(\[(.*?)\]\)", text, re.DOTALL)
    if found is None:
        raise InputError([f"{path}: {name} is missing; copy the repository again"])
    lines = (line.split("#")[0] for line in found[1].splitlines())
    return np.array([float(cell) for line in lines for cell in line.split(",") if cell.strip()])

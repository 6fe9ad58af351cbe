"""A cart on a spring with a pad of 4 mm hits a force sensor: five runs at one speed, 100 Hz, force and velocity.

Known by design: the pad of 4 mm is pressed flat, which the thicker ones are not. Only the product m v and the force's
ratio to m k matter: forces are given in units of 1/50 N, so that the soft spring lies within the limits of a data set;
mass and stiffness scale alike. Assumed: the mass that the authors' documentation has (0.5 kg) within 10 %, k_C from
its quarter period within 20 %, no pretension. The thicker pads have one speed each as well, and no known cause.
"""

import csv
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from acf_jax.dataset import Measurement, Prior, RigPrior
from acf_jax.errors import InputError
from benchmarks.measured.recorded import MeasuredSet, Recorded, cut, first_contact

SCALE = 50.0  # of force, mass and stiffness
FILE = "data/dr lee go brr - 4mm.csv"
RIG = RigPrior(
    Prior(0.5 * SCALE, 0.05 * SCALE), Prior(0.0, 5.0), Prior(0.0, 100.0), Prior(66 * SCALE, 13 * SCALE)
)
MEASUREMENT = Measurement(contact_velocity_rel_std=0.03)


def sets(copy: Path) -> Iterator[MeasuredSet]:
    """The five runs on the pad of 4 mm."""
    path = copy / FILE
    if not path.is_file():
        raise InputError(
            [f"{path} is missing; copy the repository at the commit that docs/real/pads.md names"]
        )
    with path.open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    table = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows])
    column = {name: table[:, i] for i, name in enumerate(header)}
    trials = tuple(_read(column, run) for run in range(1, 6))
    yield MeasuredSet("pads_4mm", "a cart on a spring with a pad of 4 mm", RIG, MEASUREMENT, trials)


def _read(column: dict[str, np.ndarray], run: int) -> Recorded:
    time, force = column[f"Run {run}: Time (s)"], -SCALE * column[f"Run {run}: Force (N)"]
    known = np.isfinite(time) & np.isfinite(force)
    time, force = time[known], force[known]
    contact = first_contact(time, force, 0.1 * SCALE)
    velocity = column[f"Run {run}: Velocity (m/s)"]
    clock = column[f"Run {run}: Time (s)"]
    before = np.isfinite(velocity) & (clock > contact - 0.3) & (clock < contact - 0.02)
    speed = float(velocity[before][-1])  # the last that the motion sensor read before contact
    return Recorded(f"t{run:03d}", speed, 0.0, *cut(time, force, contact, 1.0, 0.6))

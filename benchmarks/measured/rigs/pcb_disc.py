"""Thirty-two shocks of one circular circuit board on a drop table, 51.2 kHz, table and board acceleration.

Force = acceleration of the board times 0.2 kg, a mass that only sets the scale. Known by design: the sensor sits on a
board that rings at 4.2 kHz between it and the table, which hits the stop; tests 17 and 24 are marked faulty by their
authors. Assumed: the speed from the table's change of velocity at a restitution of one half, wide priors else. One
speed only.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from acf_jax.dataset import Measurement, Prior, RigPrior
from acf_jax.errors import InputError
from benchmarks.measured.recorded import Array, MeasuredSet, Recorded, cut

MASS = 0.2  # kg
RIG = RigPrior(Prior(MASS, 0.05), Prior(0.0, 100.0), Prior(0.0, 1e4), Prior(2e7, 1e7))
MEASUREMENT = Measurement(contact_velocity_rel_std=0.02)
FOLDER = Path("data/dataset-2/data-1")
RESTITUTION = 0.5
CLEAN = tuple(range(1, 13))
FAULTY = (17, 24)


def sets(copy: Path) -> Iterator[MeasuredSet]:
    """Twelve sound shocks, and ten with the two that their authors marked."""
    read = {test: _read(copy / FOLDER / f"Test_{test:03d}.lvm", test) for test in (*CLEAN, *FAULTY)}
    clean = tuple(read[test] for test in CLEAN)
    yield MeasuredSet("pcb_disc_board", "acceleration of the board", RIG, MEASUREMENT, clean)
    speed = float(np.median([t.contact_velocity for t in clean]))  # all shocks are alike
    faulty = (replace(read[test], contact_velocity=speed) for test in FAULTY)
    mixed = (*clean[:10], *faulty)
    yield MeasuredSet("pcb_disc_faulty", "with the two shocks marked faulty", RIG, MEASUREMENT, mixed)


def _read(path: Path, test: int) -> Recorded:
    if not path.is_file():
        raise InputError([f"{path} is missing; copy the whole repository"])
    table = np.genfromtxt(path, skip_header=24, delimiter=",", usecols=(0, 1, 2), invalid_raise=False)
    time, base, board = table[np.isfinite(table).all(axis=1)].T
    peak = int(np.argmax(base))
    contact = float(time[peak - 9])  # the pulse has risen to a twentieth; the toe before it is the stop's
    speed = change_of_velocity(time, base, peak) / (1 + RESTITUTION)
    return Recorded(f"t{test:03d}", speed, 0.0, *cut(time, MASS * board, contact, 0.004, 0.0015))


def change_of_velocity(time: Array, acceleration: Array, peak: int) -> float:
    """What the pulse about its peak changes the velocity by, m/s."""
    first = peak - int(np.argmax(acceleration[peak::-1] < 0.02 * acceleration[peak]))
    last = peak + int(np.argmax(acceleration[peak:] < 0.0))
    return float(np.trapezoid(acceleration[first:last], time[first:last]))

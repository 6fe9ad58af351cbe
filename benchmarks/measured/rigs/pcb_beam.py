"""Repeated shocks of a clamped circuit board, 50 kHz, base and board acceleration; the board's channel clips.

Force = acceleration of the board times 1 kg, a mass that only sets the scale; the board's channel counts the other way.
Known by design: the sensor sits on a board that rings at 0.8 kHz between it and the base, and its channel ends at
546.4 g. Assumed: the speed from the base's change of velocity at a restitution of one half, wide priors else. One
speed only.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from acf_jax.dataset import Measurement, Prior, RigPrior
from acf_jax.errors import InputError
from benchmarks.measured.recorded import STANDARD_GRAVITY, MeasuredSet, Recorded, cut
from benchmarks.measured.rigs.pcb_disc import RESTITUTION, change_of_velocity

MASS = 1.0  # kg
RIG = RigPrior(Prior(MASS, 0.25), Prior(0.0, 500.0), Prior(0.0, 1e5), Prior(1e8, 6e7))
RANGE = 546.4 * STANDARD_GRAVITY * MASS  # N
FOLDER = Path("data/dataset-1/data-1/PCB repeated shock trials")
SHOCKS = 12


def sets(copy: Path) -> Iterator[MeasuredSet]:
    """Twelve shocks, where the range's end is stated and where it is not."""
    trials = tuple(_read(copy / FOLDER, shock) for shock in range(SHOCKS))
    stated = Measurement(contact_velocity_rel_std=0.02, range_n=RANGE)
    beam = MeasuredSet("pcb_beam_board", "acceleration of the board, its range stated", RIG, stated, trials)
    yield beam
    silent = replace(stated, range_n=None)
    yield replace(beam, name="pcb_beam_silent", description="its range not stated", measurement=silent)


def _read(folder: Path, shock: int) -> Recorded:
    paths = [folder / f"acc_{channel}_a{shock}.txt" for channel in ("base", "pcb")]
    if missing := [path for path in paths if not path.is_file()]:
        raise InputError([f"{missing[0]} is missing; copy the whole repository"])
    (clock, base), (time, board) = (np.loadtxt(path).T for path in paths)
    base, board = STANDARD_GRAVITY * base, -STANDARD_GRAVITY * MASS * board
    speed = change_of_velocity(clock, base, int(np.argmax(base))) / (1 + RESTITUTION)
    crossed = int(np.argmax(board > 20 * STANDARD_GRAVITY * MASS))
    contact = float(time[max(crossed - 3, 0)])
    return Recorded(f"t{shock:03d}", speed, 0.0, *cut(time, board, contact, 0.004, 0.006))

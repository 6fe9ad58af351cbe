"""Cones dropped into water: acceleration of the body at 4 kHz, nose rigid or on a spring, 25 to 125 cm.

Force = mass of the body times its acceleration, which reads no gravity in free fall. Known by design: the contact is
the entry into water, whose force grows with the square of the speed (no law of the library), and the spring between
nose and body (8.16 or 1.74 kN/m; a nose of 65 to 69 g). Assumed: speed sqrt(2 g h) within 1 %, no flange, no
pretension, a wide k_C.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy.io import loadmat

from acf_jax.dataset import Measurement, Prior, RigPrior
from acf_jax.errors import InputError
from benchmarks.measured.recorded import STANDARD_GRAVITY, MeasuredSet, Recorded, cut

BODY = 0.5228  # kg
NOSE = {"R": 0.0668, "F": 0.0683, "S": 0.0658}  # kg: bearing, cone of 60 degrees and spring
RADIUS = 0.026  # m
HEIGHTS = ("025", "050", "075", "100", "125")  # cm
REPEATS = 3
MEASUREMENT = Measurement(contact_velocity_rel_std=0.01)
SETS = (
    ("cone_rigid_60", "R", "60", "rigid nose, half angle 60 degrees"),
    ("cone_rigid_45", "R", "45", "rigid nose, half angle 45 degrees"),
    ("cone_firm_60", "F", "60", "nose on a spring of 8.16 kN/m, half angle 60 degrees"),
    ("cone_soft_60", "S", "60", "nose on a spring of 1.74 kN/m, half angle 60 degrees"),
)


def sets(copy: Path) -> Iterator[MeasuredSet]:
    """One set a joint and angle."""
    for name, joint, angle, description in SETS:
        moving = BODY + NOSE[joint]
        rig = RigPrior(Prior(moving, 0.005), Prior(0.0, 2.0), Prior(0.0, 100.0), Prior(5000.0, 5000.0))
        trials = tuple(t for height in HEIGHTS for t in _read(copy, joint, angle, height, moving))
        yield MeasuredSet(name, description, rig, MEASUREMENT, trials)


def _read(copy: Path, joint: str, angle: str, height: str, moving: float) -> Iterator[Recorded]:
    path = copy / f"S{joint}{angle}{height}.mat"
    if not path.is_file():
        raise InputError([f"{path} is missing; copy the whole repository"])
    speed = float(np.sqrt(2 * STANDARD_GRAVITY * float(height) / 100))
    depth = RADIUS / np.tan(np.radians(float(angle)))
    # a rigid nose moves with the body; on a spring the body's inertia is the force of the joint
    mass = moving if joint == "R" else BODY
    runs = sorted(key for key in loadmat(path) if key.startswith("S"))[:REPEATS]
    for run in runs:
        time, acceleration = loadmat(path)[run][:, :2].T
        # the authors compare until the cone has gone in three times its height
        trace = cut(time, mass * STANDARD_GRAVITY * acceleration, 0.0, 0.03, 3 * depth / speed)
        yield Recorded(run.lower(), speed, 0.0, *trace)

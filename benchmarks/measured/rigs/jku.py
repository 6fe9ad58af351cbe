"""Flange tests of JKU Linz: a UR10e with an active contact flange meets a steel profile on a force sensor.

Force at 1250 Hz and the robot's velocity at 500 Hz are read off the published vector plots, one vertex a sample. The
first contact of each of the twelve runs of the ramp profile under flange control. Known by design: where the
pretension was ramped up, 10 N act at contact; the profile lies on the sensor; the robot brakes on command at 0.25 m/s.
Assumed: the moving mass (4.7 +- 0.8 kg, 3.38 kg of tool on an unpublished flange), wide priors else.
"""

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from acf_jax.dataset import Measurement, Prior, RigPrior
from acf_jax.errors import InputError
from benchmarks.measured.recorded import MeasuredSet, Recorded, cut, first_contact
from benchmarks.measured.rigs.vector_plot import read_curves

PLOTS = Path("Test_scenarios/1_Ramp_profile/2_Measurements-UR10e_ACF")
RIG = RigPrior(Prior(4.7, 0.8), Prior(100.0, 100.0), Prior(8e3, 8e3), Prior(1.5e5, 8e4))
MEASUREMENT = Measurement(0.1, contact_velocity_rel_std=0.02, pretension_rel_std=0.05)
AT_CONTACT = 10.0  # N, where the pretension is ramped up
_RUN = re.compile(r"_F_(\d+)N_t_ramp_(0\.\d)s.*_v_(0\.\d+)_1_")


def sets(copy: Path) -> Iterator[MeasuredSet]:
    """All runs without and with the measured motion, and the ramped runs with the nominal label."""
    runs = sorted((copy / PLOTS / "TcpUR_FzATI/ACF").glob("*.pdf"), key=lambda p: p.name)
    if not runs:
        raise InputError([f"{copy}: {PLOTS} has no plots; copy the whole repository"])
    read = [_read(copy, run, f"t{i:03d}") for i, run in enumerate(runs)]
    trials = tuple(trial for trial, _, _ in read)
    still = tuple(replace(t, motion=None) for t in trials)
    yield MeasuredSet("jku_brake", "ramp profile, the robot's motion withheld", RIG, MEASUREMENT, still)
    yield MeasuredSet("jku_plate", "ramp profile, with the robot's motion", RIG, MEASUREMENT, trials)
    nominal = tuple(replace(t, pretension=label) for t, label, ramped in read if ramped)
    yield MeasuredSet("jku_label", "ramped runs, labelled with the nominal force", RIG, MEASUREMENT, nominal)


def _read(copy: Path, plot: Path, name: str) -> tuple[Recorded, float, bool]:
    """A run's first contact, its nominal force, N, and whether that was ramped up."""
    found = _RUN.search(plot.name)
    if found is None:
        raise InputError([f"{plot}: the name does not tell force, ramp and speed; copy the repository again"])
    label, ramped = float(found[1]), float(found[2]) > 0
    moved = copy / PLOTS / "velocityUR/ACF" / plot.name.replace("forceATI-TcpUR_FzATI", "velocityUR")
    time, force = read_curves(plot)[0]
    near = np.abs(time) < 0.3  # the authors count time from first contact
    contact = first_contact(time[near], force[near], 5.0)
    clock, velocity = read_curves(moved)[0]
    motion = cut(clock, velocity, contact, 0.05, 0.3)
    approach = (motion[0] >= -0.018) & (motion[0] < 0.0)
    speed = float(np.mean(motion[1][approach]))
    trace = cut(time, force, contact, 0.03, 0.03)
    return Recorded(name, speed, AT_CONTACT if ramped else label, *trace, motion=motion), label, ramped

"""Crash landings of the quadcopter CogniFly: free drops on concrete, three-axis acceleration at 1 kHz.

Force = mass times acceleration along the vertical axis, which reads no gravity in free fall. Known by design: the soft
bottom is a spring with a damper that is pressed flat (the authors: 7040 N/m, 46 N s/m, flat after 16 mm). Assumed:
speed sqrt(2 g h) within 3 % (dropped by hand), no flange (k_F and d about zero), no pretension.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.signal import butter, lfilter, sosfiltfilt

from acf_jax.dataset import LowPass, Measurement, Prior, RigPrior
from acf_jax.errors import InputError
from benchmarks.measured.recorded import (
    STANDARD_GRAVITY,
    Array,
    MeasuredSet,
    Recorded,
    cut,
    with_force,
)

MASS = 0.241  # kg
COUNTS_PER_G, ZERO = 8.87700438, 2020.77284438  # of the vertical axis, by the authors' calibration
SAMPLE = np.dtype([("time", "<u4"), ("x", "<u2"), ("y", "<u2"), ("z", "<u2")])
RIG = RigPrior(Prior(MASS, 0.002), Prior(0.0, 2.0), Prior(0.0, 100.0), Prior(7040.0, 2500.0))
MEASUREMENT = Measurement(contact_velocity_rel_std=0.03, range_n=200 * STANDARD_GRAVITY * MASS)
HEIGHTS = (0.5, 1.0)  # m; from 1.5 m on the drop is faster than the 5 m/s that a data set may have
DROPS = 10  # a height: the first ones, in the order of their numbers
LAG = 60.0  # Hz, of the injected filter
WRONG = ("t010", "t011")  # drops from 1 m that the injected fault labels as ones from 0.5 m


def sets(copy: Path) -> Iterator[MeasuredSet]:
    """The soft drops; with an injected filter, clipping and lag; with two wrong labels."""
    trials: list[Recorded] = []
    for height in HEIGHTS:
        folder = copy / f"SoftBottom_{100 * height:.0f}cm"
        drops = sorted(folder.glob("*.bin"), key=lambda p: int(p.stem.rsplit("-", 1)[-1]))[:DROPS]
        if not drops:
            raise InputError([f"{folder} has no recordings; copy the whole repository"])
        trials += [_read(drop, height, f"t{len(trials) + i:03d}") for i, drop in enumerate(drops)]
    soft = MeasuredSet("cognifly_soft", "drops on the soft bottom", RIG, MEASUREMENT, tuple(trials))
    yield soft
    low_pass = LowPass(150.0, 2, zero_phase=True)
    filtered = with_force(soft, "cognifly_filtered", "the same through a stated filter", _zero_phase)
    yield replace(filtered, measurement=replace(MEASUREMENT, low_pass=low_pass, range_n=None))
    end = 80 * STANDARD_GRAVITY * MASS
    clipped = with_force(
        soft, "cognifly_clipped", "the same, cut off at 80 g", lambda _, f: np.minimum(f, end)
    )
    yield replace(clipped, measurement=replace(MEASUREMENT, range_n=end))
    lag = with_force(soft, "cognifly_lag", "the same through an unstated low-pass", _late)
    yield replace(lag, measurement=replace(MEASUREMENT, range_n=None))
    slow = trials[0].contact_velocity
    wrong = tuple(replace(t, contact_velocity=slow) if t.name in WRONG else t for t in trials)
    yield replace(
        soft, name="cognifly_label", description="the same, two drops labelled wrongly", trials=wrong
    )


def _zero_phase(_: Array, force: Array) -> Array:
    return np.asarray(sosfiltfilt(butter(2, 150.0, fs=1000.0, output="sos"), force))


def _late(time: Array, force: Array) -> Array:
    numerator, denominator = butter(1, LAG, fs=1000.0)
    return np.asarray(lfilter(numerator, denominator, force))


def _read(path: Path, height: float, name: str) -> Recorded:
    """One drop; contact is the last sample below 3 g of all axes before the first one above, as the authors have it."""
    raw = path.read_bytes()
    samples = np.frombuffer(raw[: len(raw) // SAMPLE.itemsize * SAMPLE.itemsize], SAMPLE)
    time = 1e-6 * (samples["time"] - samples["time"][0])
    g = (samples["z"] - ZERO) / COUNTS_PER_G
    side = 0.9577 * COUNTS_PER_G
    total = np.sqrt(g**2 + ((samples["x"] - 2020.0) / side) ** 2 + ((samples["y"] - 2020.0) / side) ** 2)
    hit = int(np.argmax(total > 3.0))
    trace = cut(time, MASS * STANDARD_GRAVITY * g, float(time[max(hit - 1, 0)]), 0.06, 0.04)
    return Recorded(name, float(np.sqrt(2 * STANDARD_GRAVITY * height)), 0.0, *trace)

"""A measured set as its rig's script builds it, and how it is written as a gap data set."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from acf_jax.dataset import Measurement, RigPrior
from acf_jax.documents import yaml_text
from acf_jax.errors import InputError
from acf_jax.files import write_text
from acf_jax.folders import whole_folder

Array = NDArray[np.float64]
STANDARD_GRAVITY = 9.80665  # m/s^2


@dataclass(frozen=True)
class Recorded:
    """One recorded impact; time 0 is first contact, positive force compresses."""

    name: str
    contact_velocity: float  # m/s
    pretension: float  # N
    time: Array  # s, shape (N,)
    force: Array  # N, shape (N,)
    motion: tuple[Array, Array] | None = None  # s and m/s: the robot's measured velocity
    peak: float | None = None  # N, where no trace was recorded


@dataclass(frozen=True)
class MeasuredSet:
    """A set of recorded impacts, and what is known of the rig without its force."""

    name: str
    description: str
    rig: RigPrior
    measurement: Measurement
    trials: tuple[Recorded, ...]


def cut(time: Array, values: Array, contact: float, before: float, after: float) -> tuple[Array, Array]:
    """The samples from `before` to `after` first contact, all s; time is counted from contact."""
    kept = (time >= contact - before) & (time <= contact + after)
    return time[kept] - contact, values[kept]


def first_contact(time: Array, force: Array, threshold: float) -> float:
    """Time of the last sample before the force first exceeds the threshold, N, in s."""
    first = int(np.argmax(force > threshold))
    if first == 0:
        raise InputError(
            ["the recording begins within the impact, or has none; it needs samples before contact"]
        )
    return float(time[first - 1])


def with_force(
    measured: MeasuredSet, name: str, description: str, change: Callable[[Array, Array], Array]
) -> MeasuredSet:
    """The same set under another name, each force replaced by `change(time, force)`: an injected cause."""
    trials = tuple(replace(t, force=change(t.time, t.force)) for t in measured.trials)
    return replace(measured, name=name, description=description, trials=trials)


def write_set(measured: MeasuredSet, folder: Path) -> None:
    """Write one set whole or not at all: dataset.yaml, trials.csv, traces/ and, where measured, motion/."""
    with whole_folder(folder) as scratch:
        write_text(scratch / "dataset.yaml", yaml_text(_description(measured)))
        write_text(scratch / "trials.csv", _trials(measured.trials))
        for trial in measured.trials:
            if trial.peak is None:
                trace = _table("time_s,force_n", trial.time, trial.force)
                write_text(scratch / "traces" / f"{trial.name}.csv", trace)
            if trial.motion is not None:
                motion = _table("time_s,robot_velocity_m_per_s", *trial.motion)
                write_text(scratch / "motion" / f"{trial.name}.csv", motion)


def _description(measured: MeasuredSet) -> dict[str, object]:
    rig, how = measured.rig, measured.measurement
    names = (
        "moving_mass_kg",
        "damping_n_s_per_m",
        "actuator_stiffness_n_per_m",
        "contact_stiffness_n_per_m",
    )
    priors = (rig.m, rig.d, rig.k_f, rig.k_c)
    measurement: dict[str, object] = {
        "contact_velocity_rel_std": how.contact_velocity_rel_std,
        "pretension_rel_std": how.pretension_rel_std,
    }
    if how.force_noise_std_n is not None:
        measurement["force_noise_std_n"] = how.force_noise_std_n
    if how.range_n is not None:
        measurement["range_n"] = how.range_n
    if how.low_pass is not None:
        low_pass = how.low_pass
        measurement["low_pass"] = {
            "cutoff_hz": low_pass.cutoff_hz,
            "order": low_pass.order,
            "zero_phase": low_pass.zero_phase,
        }
    return {
        "schema": "acf-gap-dataset/1",
        "description": measured.description,
        "rig": {
            n: {"value": float(p.value), "std": float(p.std)} for n, p in zip(names, priors, strict=True)
        },
        "measurement": measurement,
    }


def _trials(trials: Sequence[Recorded]) -> str:
    moves = any(t.motion is not None for t in trials)
    peaks = any(t.peak is not None for t in trials)
    columns = ["trial", "contact_velocity_m_per_s", "pretension_n", "peak_force_n" if peaks else "trace"]
    rows = [",".join([*columns, "motion"] if moves else columns)]
    for t in trials:
        cells = [t.name, f"{t.contact_velocity:.6g}", f"{t.pretension:.6g}"]
        cells.append(f"{t.peak:.6g}" if t.peak is not None else f"traces/{t.name}.csv")
        if moves:
            cells.append(f"motion/{t.name}.csv" if t.motion is not None else "")
        rows.append(",".join(cells))
    return "\n".join(rows) + "\n"


def _table(header: str, time: Array, values: Array) -> str:
    rows = (f"{t:.7f},{v:.6g}" for t, v in zip(time, values, strict=True))
    return "\n".join([header, *rows]) + "\n"

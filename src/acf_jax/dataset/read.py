"""Read a gap data set from its folder, or reject it with all its faults at once."""

import re
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from acf_jax.dataset import units
from acf_jax.dataset.columns import read_columns
from acf_jax.dataset.description import read_description
from acf_jax.dataset.table import Row, Table, read_table
from acf_jax.dataset.trials import Array, GapDataset, Measurement, RigPrior, RobotVelocity, Trace, Trial
from acf_jax.errors import InputError, collected, merged, shown
from acf_jax.files import inside

_CONDITION = ("trial", "contact_velocity_m_per_s", "pretension_n")
_RESULT = ("peak_force_n", "trace")
_FILES = ("trace", "motion")  # columns that name a file each
_MOST_TRIALS = 10_000
_PARTS = ("dataset.yaml", "trials.csv", "traces")  # of a data set
_SAFE_NAME = re.compile(r"\w([\w .+-]{0,98}\w)?", re.ASCII)


def data_sets(folder: Path) -> list[str]:
    """The names of the data sets in a folder, incomplete ones included; `InputError` where there is none."""
    names = sorted({path.parent.name for part in _PARTS for path in folder.glob(f"*/{part}")})
    if not names:
        raise InputError(
            f"{folder}: holds no data sets; name a folder whose folders hold a dataset.yaml each"
        )
    return names


def read_dataset(folder: str | Path) -> GapDataset:
    """Read the data set in `folder`: dataset.yaml, trials.csv and the files listed there, nothing else.

    Raises `InputError` that lists every fault of the data set with file, row or key, and remedy.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder; name a folder with dataset.yaml and trials.csv")
    faults: list[str] = []
    description, rig, measurement = "", units.TYPICAL_RIG, Measurement()
    try:
        description, rig, measurement = read_description(_inside(folder, "dataset.yaml"))
    except InputError as error:
        faults += error.faults
    trials = _read_trials(folder, rig, faults)
    low_pass = measurement.low_pass
    if low_pass and (fault := units.low_pass_fault(low_pass, rig.impact_time, trials)):
        faults.append(f"{folder / 'dataset.yaml'}: measurement.low_pass: {fault}")
    if measurement.range_n and (fault := units.range_fault(measurement.range_n, trials)):
        faults.append(f"{folder / 'dataset.yaml'}: {fault}")
    if faults:
        raise InputError(faults)
    return GapDataset(folder, description, rig, measurement, tuple(trials))


def read_conditions(path: str | Path) -> tuple[Trial, ...]:
    """Read the conditions to predict: trials with neither peak nor trace, named as files can be named.

    Raises `InputError` that lists every fault of the file.
    """
    table = read_table(Path(path), _CONDITION)
    trials: list[Trial] = []
    if not table.faults:
        rows = [(row, _trial(table, row)) for row in table.rows]
        _check_names(table, [(row, trial.name.casefold()) for row, trial in rows if trial])
        for row, trial in rows:
            if trial and not _SAFE_NAME.fullmatch(trial.name):
                what = f"trial {shown(trial.name)} cannot name a file; use letters, digits, '_', '-' and '.'"
                table.fault(f"row {row.number}", what)
        trials = [trial for _, trial in rows if trial]
        if not table.rows:
            table.fault("", "has no rows; list at least one condition")
        if fault := units.pretension_column_fault([t.pretension for t in trials]):
            table.fault("", fault)
    if table.faults:
        raise InputError(table.shown_faults())
    return tuple(trials)


def _inside(folder: Path, relative: str) -> Path:
    """`folder / relative`, as written, once it is known not to leave the folder."""
    try:
        inside(folder, relative)
        if relative.isprintable() and len(relative.encode()) < 256:
            return folder / relative
    except InputError:
        raise
    except (OSError, ValueError, RuntimeError):  # a name that the system refuses, a loop of links
        pass
    raise InputError(f"{shown(relative)} is not a path; name a file in {folder}")


def _read_trials(folder: Path, rig: RigPrior, faults: list[str]) -> list[Trial]:
    """The trials of trials.csv with their traces; what is wrong with them is added to `faults`."""
    try:
        table = read_table(_inside(folder, "trials.csv"), _CONDITION)
    except InputError as error:
        faults += error.faults
        return []
    if not all(column in table.columns for column in _CONDITION):
        faults += table.shown_faults()
        return []
    if not any(column in table.columns for column in _RESULT):
        table.fault("", "columns 'peak_force_n' and 'trace' are both missing; add at least one")
    if len(table.rows) < 3:
        table.fault("", f"lists {len(table.rows)} trials; a diagnosis needs at least 3")
    if len(table.rows) > _MOST_TRIALS:  # each is compared with the others
        faults.append(f"{table.path}: lists {len(table.rows):,} trials; give {_MOST_TRIALS:,} at most")
        return []
    rows = [(row, _trial(table, row)) for row in table.rows]
    _check_names(table, [(row, row.cells["trial"]) for row in table.rows])
    trials = [trial for _, trial in rows if trial]
    for fault in (
        units.pretension_column_fault([t.pretension for t in trials]),
        units.peak_column_fault(rig, trials),
    ):
        if fault:
            table.fault("", fault)
    for row in table.rows:
        if not any(row.cells.get(column, "") for column in _RESULT) and set(_RESULT) & set(table.columns):
            where = f"row {row.number} (trial {shown(row.cells['trial'])})"
            table.fault(where, "has neither peak_force_n nor trace; fill one, or remove the row")

    owners: dict[Path, str] = {}
    of_files: list[tuple[str, list[str]]] = []
    traces, motions = {}, {}
    for number, path, trial in _files(table, rows, "trace", owners):
        expected = units.expected_peak(rig, trial) if trial else None
        if trace := collected(
            _faults_of(path, of_files), partial(_read_trace, path, rig.impact_time, expected)
        ):
            traces[number] = trace
    for number, path, trial in _files(table, rows, "motion", owners):
        speed = trial.contact_velocity if trial else None
        if motion := collected(
            _faults_of(path, of_files), partial(_read_motion, path, rig.impact_time, speed)
        ):
            motions[number] = motion
    if fault := units.sign_fault(list(traces.values())):
        table.fault("", fault)
    faults += table.shown_faults() + merged(of_files)
    return [
        replace(trial, trace=traces.get(row.number), motion=motions.get(row.number))
        for row, trial in rows
        if trial
    ]


def _faults_of(path: Path, of_files: list[tuple[str, list[str]]]) -> list[str]:
    """The faults of one more file, which has none yet."""
    of_files.append((str(path), []))
    return of_files[-1][1]


def _trial(table: Table, row: Row) -> Trial | None:
    """The trial of one row, without its trace; None, and faults, when a cell is wrong."""
    name = row.cells["trial"]
    where = f"row {row.number} (trial {shown(name)})"
    if not name:
        table.fault(f"row {row.number}", "trial is empty; give each trial a name of its own")
    velocity = table.number(row, "contact_velocity_m_per_s", where)
    pretension = table.number(row, "pretension_n", where)
    peak = table.number(row, "peak_force_n", where) if row.cells.get("peak_force_n") else None
    limits = (
        ("contact_velocity_m_per_s", velocity, units.VELOCITY),
        ("pretension_n", pretension, units.PRETENSION),
    )
    right = bool(name)
    for column, value, limit in limits:
        if value is not None and (fault := limit.fault(value)):
            table.fault(where, f"{column} {fault}")
            right = False
    if peak is not None and (fault := units.peak_fault(peak)):
        table.fault(where, f"peak_force_n {fault}")
    if not right or velocity is None or pretension is None:
        return None
    known = _CONDITION + _RESULT + _FILES
    other = {key: cell for key, cell in row.cells.items() if key and key not in known}
    return Trial(name, velocity, pretension, peak, None, other)


def _check_names(table: Table, names: list[tuple[Row, str]]) -> None:
    first: dict[str, int] = {}
    for row, name in names:
        if name and name in first:
            what = f"trial {shown(name)} is already in row {first[name]}; give each trial a name of its own"
            table.fault(f"row {row.number}", what)
        first.setdefault(name, row.number)


def _files(
    table: Table, rows: list[tuple[Row, Trial | None]], column: str, owners: dict[Path, str]
) -> Iterator[tuple[int, Path, Trial | None]]:
    """The file that each row of trials.csv names in a column; those of rows whose condition is faulty, too.

    `owners`: which cell has each file already, which grows.
    """
    for row, trial in rows:
        relative = row.cells.get(column, "")
        where = f"row {row.number} (trial {shown(row.cells['trial'])})"
        if not relative:
            continue
        try:
            path = _inside(table.path.parent, relative)
        except InputError as error:
            table.fault(where, f"{column} {error.faults[0]}")
            continue
        cell = f"row {row.number}" if column == "trace" else f"row {row.number}, {column}"
        owner = owners.setdefault(path.resolve(), cell)
        if owner != cell:
            table.fault(where, f"{column} is that of {owner} already; give each trial its own {column}")
            continue
        yield row.number, path, trial


def _read_trace(path: Path, impact_time: float, expected: float | None) -> Trace:
    """The trace in a file; `InputError` with its faults, judged against impact time, s, and peak, N."""
    trace = Trace(*_read_signal(path, "force_n"))
    of_time = units.time_fault(trace, impact_time)
    of_force = units.force_fault(trace, expected) if expected else None
    if faults := [f"{path}: {fault}" for fault in (of_time, of_force) if fault]:
        raise InputError(faults)
    return trace


def _read_motion(path: Path, impact_time: float, contact_velocity: float | None) -> RobotVelocity:
    """The robot's velocity in a file; `InputError` with its faults, judged against impact time, s, and m/s."""
    motion = RobotVelocity(*_read_signal(path, "robot_velocity_m_per_s"))
    if fault := units.motion_fault(motion, contact_velocity, impact_time):
        raise InputError(f"{path}: {fault}")
    return motion


def _read_signal(path: Path, column: str) -> tuple[Array, Array]:
    """Time, s, and a column over it; `InputError` where the file holds no signal."""
    table, (lines, samples) = read_columns(path, ("time_s", column))
    if not table.faults and not lines.size:
        cell = "trace" if column == "force_n" else "motion"
        table.fault("", f"holds no samples; record the {cell} again, or leave the cell `{cell}` empty")
    if table.faults:
        raise InputError(table.shown_faults())
    time, value = samples.T
    for index in np.flatnonzero(np.diff(time) <= 0.0):
        what = f"time_s is {time[index + 1]:g} after {time[index]:g}; time must increase from row to row"
        table.fault(f"row {lines[index + 1]}", what)
        if table.is_hopeless:
            break
    if time.size < 3:
        table.fault("", f"holds {time.size} samples; record the whole impact")
    if table.faults:
        raise InputError(table.shown_faults())
    return _frozen(time), _frozen(value)


def _frozen(values: Array) -> Array:
    values = np.ascontiguousarray(values)
    values.flags.writeable = False
    return values

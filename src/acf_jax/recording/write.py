"""The cuts of a recording as a gap data set."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from acf_jax.dataset import GapDataset, read_dataset
from acf_jax.dataset.description import SCHEMA
from acf_jax.dataset.trials import RobotVelocity
from acf_jax.documents import yaml_text
from acf_jax.errors import InputError
from acf_jax.files import write_text
from acf_jax.recording.cut import Cut
from acf_jax.recording.impacts import Impacts, Refused
from acf_jax.recording.review import AUTO, Entry, review_text
from acf_jax.recording.rig import BY_IMPORT, MEASURED, TEMPLATE, RigFile

CUTS, REFUSED = "import.html", "import_refused.html"  # the pages of an import, in its data set's folder
COLUMNS = (
    "trial,contact_velocity_m_per_s,pretension_n,peak_force_n,trace,"
    "measured_velocity_m_per_s,measured_velocity_std_m_per_s,measured_pretension_n,contact_s"
)


def write_impacts(folder: Path, impacts: Impacts, rig: RigFile | None) -> GapDataset | None:
    """Write dataset.yaml, trials.csv, traces/ and, where the robot's motion was measured, motion/.

    **Returns:** the data set, read back as `diagnose` would; None without a rig.

    **Raises:** `Refused` when what was written is no sound data set.
    """
    write_text(folder / "dataset.yaml", _description(impacts, rig))
    is_moved = any(cut.motion is not None for cut in impacts.kept)
    rows = [_row(impacts, cut) + _motion_cell(cut) * is_moved for cut in impacts.kept]
    write_text(folder / "trials.csv", "\n".join([COLUMNS + ",motion" * is_moved, *rows, ""]))
    for cut in impacts.kept:
        write_text(folder / "traces" / f"{cut.trial}.csv", trace_text(cut))
        if cut.motion is not None:
            write_text(folder / "motion" / f"{cut.trial}.csv", motion_text(cut.motion))
    if rig is None:
        return None
    try:
        return read_dataset(folder)
    except InputError as error:
        faults = tuple(_of_contact(fault.replace(f"{folder}/", ""), impacts) for fault in error.faults)
        raise Refused(replace(impacts, faults=faults)) from None


def _of_contact(fault: str, impacts: Impacts) -> str:
    """A fault of the data set with the contact in place of a row or a file that is not there."""
    for cut in impacts.kept:
        contact = f"contact at {_seconds(impacts, cut):.6g} s (trial {cut.trial!r})"
        fault = re.sub(rf"^trials\.csv row \d+ \(trial {re.escape(repr(cut.trial))}\)", contact, fault)
        fault = re.sub(rf"^traces/{re.escape(cut.trial)}\.csv( row \d+)?(?=\W)", contact, fault)
    return fault


def trace_text(cut: Cut) -> str:
    """The trace as CSV: times to the nanosecond, every force as it was read."""
    rows = zip(cut.time.tolist(), cut.force.tolist(), strict=True)
    return "\n".join(["time_s,force_n", *(f"{1e-9 * t:.9f},{f!r}" for t, f in rows), ""])


def motion_text(motion: RobotVelocity) -> str:
    """The robot's velocity as CSV."""
    rows = zip(motion.time.tolist(), motion.value.tolist(), strict=True)
    return "\n".join(["time_s,robot_velocity_m_per_s", *(f"{t:.9f},{v!r}" for t, v in rows), ""])


def review_of(impacts: Impacts) -> str:
    """cuts.yaml of what was found; where no data set came of it nothing is decided."""
    decided = [
        (entry_of(impacts, cut, None if impacts.faults else cut.keep), _comment(cut)) for cut in impacts.cuts
    ]
    return review_text(impacts.session.path.name, decided)


def entry_of(impacts: Impacts, cut: Cut, keep: bool | None) -> Entry:
    """What a review says of a cut; `keep` None: the checks decide."""
    said = AUTO if keep is None else keep
    return Entry.model_validate({"trial": cut.trial, "contact_s": _seconds(impacts, cut), "keep": said})


def _description(impacts: Impacts, rig: RigFile | None) -> str:
    own = (rig.description if rig else "") or f"{BY_IMPORT}{impacts.session.path.name}"
    head = yaml_text({"schema": SCHEMA, "description": own})
    measured = zip(MEASURED, (impacts.velocity_spread, impacts.pretension_spread), strict=True)
    spread = {key: min(value, 0.25) for key, value in measured if value is not None}
    measurement = spread | (rig.measurement if rig else {})
    body = yaml_text({"rig": rig.rig}) if rig else TEMPLATE
    return head + body + (yaml_text({"measurement": measurement}) if measurement else "")


def _row(impacts: Impacts, cut: Cut) -> str:
    v_e, f_p = cut.condition
    cells: Sequence[str] = (
        cut.trial,
        f"{v_e:g}",
        f"{f_p:g}",
        repr(cut.peak)
        if cut.peak is not None and cut.peak > 0.0
        else "",  # of an untared sensor: in the trace
        f"traces/{cut.trial}.csv",
        f"{cut.velocity.value:.6g}",
        f"{cut.velocity.std:.2g}",
        f"{cut.pretension.value:.6g}",
        f"{_seconds(impacts, cut):.9f}",
    )
    return ",".join(cells)


def _motion_cell(cut: Cut) -> str:
    return f",motion/{cut.trial}.csv" if cut.motion is not None else ","


def _seconds(impacts: Impacts, cut: Cut) -> float:
    """First contact since the first force sample, s."""
    return max(1e-9 * (cut.contact.begin - int(impacts.session.force.time[0])), 0.0)


def _comment(cut: Cut) -> str:
    return "; ".join([cut.words, *cut.remarks])

"""The contact force over time for several velocities, as in Fig. 2 of the paper."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np

from acf_jax.files import write_text
from acf_jax.gap_model import GapModel
from acf_jax.model import Impact, Rig, contact_force
from acf_jax.predict import predict
from acf_jax.report.page import figure_page
from acf_jax.report.plot import Variant, axis, plot, series

COLOURS = tuple(f"--scale-{k}" for k in range(5))


class Curve(NamedTuple):
    """The contact force of one impact, until contact is lost."""

    v_e: float  # m/s
    time: np.ndarray  # s, shape (N,)
    force: np.ndarray  # N, shape (N,)


def rig_curves(rig_values: dict[str, float], rows: Sequence[dict[str, Any]], f_p: float) -> list[Curve]:
    """Of the paper's model; `rows`: `v_e` of each, and its peak where it has one."""
    rig = Rig(**rig_values)
    # long enough for each peak to be seen to pass; half a period where there is none
    half_period = float(np.pi / rig.omega)
    times = np.linspace(0, max([half_period, *(1.3 * row["t_max"] for row in rows if row["has_peak"])]), 400)
    forces = jax.jit(jax.vmap(jax.vmap(contact_force, (None, None, 0)), (None, 0, None)))
    velocities = np.array([row["v_e"] for row in rows])
    found = np.asarray(forces(rig, Impact(velocities, np.full_like(velocities, f_p)), times))
    return [Curve(v, *_in_contact(times, force)) for v, force in zip(velocities, found, strict=True)]


def model_curves(gap: GapModel, v_e: Sequence[float], f_p: float) -> list[Curve]:
    """Of the model that answers for a diagnosis."""
    found = predict(gap, np.array(v_e), np.full(len(v_e), f_p), gap.preferred, 2e4)
    return [Curve(v, *_in_contact(p.time, p.contact_force)) for v, p in zip(v_e, found, strict=True)]


def write_force_plot(path: Path, curves: Sequence[Curve], rows: Sequence[dict[str, Any]]) -> None:
    """Write an HTML file that needs no network: one curve a velocity, its peak marked.

    **Arguments:** `rows`: `has_peak`, `t_max` and `f_max` of each velocity.
    """
    data: list[dict[str, Any]] = [
        {
            "type": "scatter", "mode": "lines", "name": f"v = {curve.v_e:g} m/s",
            "x": series(1e3 * curve.time), "y": series(curve.force),
            "line": {"color": COLOURS[k % len(COLOURS)], "width": 2},
        }
        for k, curve in enumerate(curves)
    ]  # fmt: skip
    found = [row for row in rows if row["has_peak"]]
    data.append(
        {
            "type": "scatter", "mode": "markers", "name": "peak",
            "x": series(1e3 * row["t_max"] for row in found), "y": series(row["f_max"] for row in found),
            "marker": {"symbol": "x", "size": 9, "color": "--measured"},
        }
    )  # fmt: skip
    layout = {
        "showlegend": True,
        "xaxis": axis("time since contact / ms"),
        "yaxis": axis("contact force / N", rangemode="tozero"),
    }
    drawn = plot("force", "Contact force after contact", "", [Variant("", data)], layout, 520)
    write_text(path, figure_page("Contact force", drawn))


def _in_contact(time: np.ndarray, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The samples until the force falls to zero: nothing pulls, so contact is lost there."""
    lost = np.flatnonzero(force <= 0.0)
    lost = lost[lost > 0]
    if not lost.size:
        return time, force
    end = int(lost[0])
    rest = force[end - 1] / (force[end - 1] - force[end]) if force[end - 1] > force[end] else 1.0
    zero = time[end - 1] + rest * (time[end] - time[end - 1])
    return np.r_[time[:end], zero], np.r_[force[:end], 0.0]

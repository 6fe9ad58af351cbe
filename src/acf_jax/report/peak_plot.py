"""The contact force over time for several velocities, as in Fig. 2 of the paper."""

from pathlib import Path
from typing import Any

import jax
import numpy as np

from acf_jax.files import write_text
from acf_jax.model import Impact, Rig, contact_force
from acf_jax.report.page import figure_page
from acf_jax.report.plot import Variant, axis, plot, series

COLOURS = tuple(f"--scale-{k}" for k in range(5))


def write_force_plot(
    path: Path, rig_values: dict[str, float], rows: list[dict[str, Any]], f_p: float
) -> None:
    """Write an HTML file that needs no network: one curve a velocity, its peak marked."""
    rig = Rig(**rig_values)
    # long enough for each peak to be seen to pass; half a period where there is none
    half_period = float(np.pi / rig.omega)
    times = np.linspace(0, max([half_period, *(1.3 * row["t_max"] for row in rows if row["has_peak"])]), 400)
    curves = jax.jit(jax.vmap(jax.vmap(contact_force, (None, None, 0)), (None, 0, None)))
    velocities = np.array([row["v_e"] for row in rows])
    forces = np.asarray(curves(rig, Impact(velocities, np.full_like(velocities, f_p)), times))
    x = series(1e3 * times)
    data: list[dict[str, Any]] = [
        {
            "type": "scatter", "mode": "lines", "name": f"v = {row['v_e']:g} m/s", "x": x, "y": series(force),
            "line": {"color": COLOURS[k % len(COLOURS)], "width": 2},
        }
        for k, (row, force) in enumerate(zip(rows, forces, strict=True))
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
        "yaxis": axis("contact force / N"),
    }
    drawn = plot("force", "Contact force after contact", "", [Variant("", data)], layout, 520)
    write_text(path, figure_page("Contact force", drawn))

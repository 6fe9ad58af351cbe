"""The contact force over time for several velocities, as in Fig. 2 of the paper."""

from pathlib import Path
from typing import Any

import jax
import numpy as np
import plotly.graph_objects as go

from acf_jax.files import write_text
from acf_jax.model import Impact, Rig, contact_force


def write_force_plot(
    path: Path, rig_values: dict[str, float], rows: list[dict[str, Any]], f_p: float
) -> None:
    """Write an HTML file that needs no network: one curve a velocity, its peak marked."""
    rig = Rig(**rig_values)
    # long enough for each peak to be seen to pass; half a period where there is none
    half_period = float(np.pi / rig.omega)
    times = np.linspace(0, max([half_period, *(1.3 * row["t_max"] for row in rows if row["has_peak"])]), 400)
    figure = go.Figure()
    curves = jax.jit(jax.vmap(jax.vmap(contact_force, (None, None, 0)), (None, 0, None)))
    velocities = np.array([row["v_e"] for row in rows])
    forces = curves(rig, Impact(velocities, np.full_like(velocities, f_p)), times)
    for row, force in zip(rows, np.asarray(forces), strict=True):
        figure.add_scatter(x=1e3 * times, y=force, mode="lines", name=f"v = {row['v_e']:g} m/s")
    found = [row for row in rows if row["has_peak"]]
    figure.add_scatter(
        x=[1e3 * row["t_max"] for row in found],
        y=[row["f_max"] for row in found],
        mode="markers",
        marker={"symbol": "x", "size": 9, "color": "black"},
        name="peak",
    )
    figure.update_layout(
        template="plotly_white",
        title="Contact force after contact",
        xaxis_title="time since contact / ms",
        yaxis_title="contact force / N",
    )
    write_text(path, figure.to_html(include_plotlyjs=True, full_html=True))

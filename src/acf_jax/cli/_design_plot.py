"""The design space in the browser: the force that is not exceeded, the limit and the optimum."""

from pathlib import Path

import plotly.graph_objects as go

from acf_jax.design.landscape import landscape
from acf_jax.design.solve import Design
from acf_jax.files import write_text

AXES = {"v_e": "contact velocity", "f_p": "pretension", "k_c": "contact stiffness", "m": "moving mass"}
LIMIT = "#d9480f"


def write_design_plot(path: Path, found: Design) -> None:
    """Write an HTML file that needs no network."""
    space, limit = landscape(found), found.task.limit
    titles = [f"{AXES.get(n, n)}, {u}" for n, u in zip(space.names, space.units, strict=True)]
    figure = go.Figure()
    if len(space.axes) == 1:
        x = space.axes[0]
        figure.add_scatter(x=x, y=space.force, mode="lines", name="expected")
        figure.add_scatter(
            x=x, y=space.upper, mode="lines", name=f"not exceeded, P = {found.task.probability:g}"
        )
        figure.add_hline(y=limit, line_color=LIMIT, annotation_text=f"limit {limit:g} N")
        optimum_y, y_title = found.upper, "peak contact force, N"
    else:
        figure.add_contour(
            x=space.axes[0], y=space.axes[1], z=space.upper, colorscale="Blues", colorbar={"title": {"text": "N"}},
            contours={"showlabels": True}, line={"width": 0.5},
        )  # fmt: skip
        figure.add_contour(
            x=space.axes[0], y=space.axes[1], z=space.upper, showscale=False, name=f"limit {limit:g} N",
            contours={"type": "constraint", "operation": ">", "value": limit},
            fillcolor="rgba(217,72,15,0.25)", line={"color": LIMIT, "width": 2}, showlegend=True,
        )  # fmt: skip
        optimum_y, y_title = space.optimum[1], titles[1]
    figure.add_scatter(
        x=[space.optimum[0]],
        y=[optimum_y],
        mode="markers",
        marker={"symbol": "star", "size": 14, "color": "black"},
        name="optimum",
    )
    figure.update_layout(
        template="plotly_white",
        title=f"Peak contact force not exceeded with a probability of {found.task.probability:g}",
        xaxis_title=titles[0],
        yaxis_title=y_title,
        legend={"orientation": "h", "y": -0.2},
    )
    write_text(path, figure.to_html(include_plotlyjs=True, full_html=True))

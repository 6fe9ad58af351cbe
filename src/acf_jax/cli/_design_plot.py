"""The design space in the browser: the force that is not exceeded, the limit, and the point that was found."""

from pathlib import Path

import plotly.graph_objects as go

from acf_jax.design.landscape import landscape
from acf_jax.design.remedy import Infeasible
from acf_jax.design.solve import Design
from acf_jax.files import write_text

AXES = {"v_e": "contact velocity", "f_p": "pretension", "k_c": "contact stiffness", "m": "moving mass"}
LIMIT = "#d9480f"


def write_design_plot(path: Path, found: Design | Infeasible) -> None:
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
        y, y_title = found.upper, "peak contact force, N"
    else:
        is_allowed_somewhere = bool((space.upper <= limit).any())
        figure.add_contour(
            x=space.axes[0], y=space.axes[1], z=space.upper, colorbar={"title": {"text": "N"}},
            colorscale="Blues" if is_allowed_somewhere else "Reds",
            contours={"showlabels": True}, line={"width": 0.5},
        )  # fmt: skip
        if is_allowed_somewhere:
            figure.add_contour(
                x=space.axes[0], y=space.axes[1], z=space.upper, showscale=False, name=f"limit {limit:g} N",
                contours={"type": "constraint", "operation": ">", "value": limit},
                fillcolor="rgba(217,72,15,0.25)", line={"color": LIMIT, "width": 2}, showlegend=True,
            )  # fmt: skip
        y, y_title = space.point[1], titles[1]
    is_feasible = isinstance(found, Design)
    symbol, name = ("star", "optimum") if is_feasible else ("x", "least loaded")
    heading = "" if is_feasible else f"Not feasible: nowhere within {limit:g} N.<br>"
    figure.add_scatter(
        x=[space.point[0]],
        y=[y],
        mode="markers",
        marker={"symbol": symbol, "size": 14, "color": "black"},
        name=name,
    )
    figure.update_layout(
        template="plotly_white",
        title=f"{heading}Peak contact force not exceeded with a probability of {found.task.probability:g}",
        xaxis_title=titles[0],
        yaxis_title=y_title,
        showlegend=True,
        legend={"orientation": "h", "y": -0.2},
    )
    write_text(path, figure.to_html(include_plotlyjs=True, full_html=True))

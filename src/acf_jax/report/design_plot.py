"""The design space in the browser: the force that is not exceeded, the limit, and the point that was found."""

from pathlib import Path
from typing import Any

import plotly.graph_objects as go

from acf_jax.designs.landscape import Landscape, landscape
from acf_jax.designs.remedy import Infeasible
from acf_jax.designs.solve import Design
from acf_jax.files import write_text
from acf_jax.report.notebook import to_plotly
from acf_jax.report.page import figure_page
from acf_jax.report.plot import Drawn, Variant, axis, plot, series

AXES = {"v_e": "contact velocity", "f_p": "pretension", "k_c": "contact stiffness", "m": "moving mass"}
SCALE = [[0, "--low"], [1, "--high"]]


def write_design_plot(path: Path, found: Design | Infeasible) -> None:
    """Write an HTML file that needs no network."""
    write_text(path, figure_page("Design", design_drawing(found)))


def design_figure(found: Design | Infeasible) -> go.Figure:
    """The figure itself: a curve over one free quantity, a map over two."""
    return to_plotly(design_drawing(found))


def design_drawing(found: Design | Infeasible) -> Drawn:
    """The same for a page."""
    space, limit, task = landscape(found), found.task.limit, found.task
    titles = [f"{AXES.get(n, n)}, {u}" for n, u in zip(space.names, space.units, strict=True)]
    is_feasible = isinstance(found, Design)
    is_curve = len(space.axes) == 1
    symbol, name = ("star", "optimum") if is_feasible else ("x", "least loaded")
    point = {
        "type": "scatter", "mode": "markers", "name": name,
        "x": series(space.point[:1], 8), "y": series([found.upper if is_curve else space.point[1]], 8),
        "marker": {"symbol": symbol, "size": 14, "color": "--measured", "line": {"color": "--page", "width": 1}},
    }  # fmt: skip
    heading = "" if is_feasible else f"Not feasible: nowhere within {limit:g} N. "
    title = f"{heading}Peak contact force not exceeded with a probability of {task.probability:g}"
    layout: dict[str, Any] = {"showlegend": True, "xaxis": axis(titles[0])}
    layout["yaxis"] = axis("peak contact force, N" if is_curve else titles[1])
    drawn = _curves(space, task.probability, limit) if is_curve else _map(space, limit)
    return plot("design", title, "", [Variant("", [*drawn, point])], layout, 520)


def _curves(space: Landscape, probability: float, limit: float) -> list[dict[str, Any]]:
    x = series(space.axes[0])
    ends = [x[0], x[-1]]
    lines = (
        ("expected", x, series(space.force), {"color": "--recalibrated", "width": 2}),
        (f"not exceeded, P = {probability:g}", x, series(space.upper), {"color": "--corrected", "width": 2}),
        (f"limit {limit:g} N", ends, [limit, limit], {"color": "--bad", "width": 2, "dash": "dash"}),
    )
    return [
        {"type": "scatter", "mode": "lines", "name": name, "x": across, "y": up, "line": line}
        for name, across, up, line in lines
    ]


def _map(space: Landscape, limit: float) -> list[dict[str, Any]]:
    place = {
        "x": series(space.axes[0]),
        "y": series(space.axes[1]),
        "z": [series(row) for row in space.upper],
    }
    force = {
        "type": "contour", **place, "colorscale": SCALE, "name": "force",
        "colorbar": {"title": {"text": "N"}, "outlinewidth": 0},
        "contours": {"showlabels": True, "labelfont": {"color": "--ink"}}, "line": {"width": 0.5, "color": "--muted"},
    }  # fmt: skip
    if not (space.upper <= limit).any():
        return [force]
    edge = {
        "type": "contour", **place, "showscale": False, "name": f"limit {limit:g} N", "showlegend": True,
        "contours": {"type": "constraint", "operation": ">", "value": limit},
        "fillcolor": "--band", "line": {"color": "--bad", "width": 2},
    }  # fmt: skip
    return [force, edge]

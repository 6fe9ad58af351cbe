"""The report's figures for a notebook or a script: Plotly's own figures.

They are light, or dark where Plotly's default template is: `plotly.io.templates.default = "plotly_dark"`.
"""

from typing import Any

import plotly.graph_objects as go
import plotly.io as pio

from acf_jax.report.plot import Drawn, Variant, plain
from acf_jax.style import colours

CHOOSER = 40  # pixels that the choice among variants takes above the figure
TITLE = 60


def to_plotly(drawn: Drawn) -> go.Figure:
    """The figure of a report as one that shows itself; a menu chooses among its variants."""
    figure = drawn.figure
    shown = go.Figure(layout=_layout(drawn, figure.variants[figure.first]))
    owners = []
    for k, variant in enumerate(figure.variants):
        for trace in variant.data:
            owners.append((k, trace.get("visible", True)))
            shown.add_trace(coloured(trace) | {"visible": owners[-1][1] if k == figure.first else False})
    if len(figure.variants) > 1:
        buttons = [
            {
                "label": plain(variant.label),
                "method": "update",
                "args": [
                    {"visible": [visible if own == k else False for own, visible in owners]},
                    _layout(drawn, variant),
                ],
            }
            for k, variant in enumerate(figure.variants)
        ]
        place = {"x": 0, "xanchor": "left", "y": 1, "yanchor": "bottom", "pad": {"b": CHOOSER}}
        shown.update_layout(updatemenus=[{"buttons": buttons, "active": figure.first, **place}])
    return shown


def coloured(value: Any) -> Any:
    """The value with every name of a colour in style.css replaced by the colour."""
    if isinstance(value, str):
        return colours(_is_dark())[value] if value.startswith("--") else value
    if isinstance(value, dict):
        return {key: coloured(item) for key, item in value.items()}
    return [coloured(item) for item in value] if isinstance(value, list | tuple) else value


def _layout(drawn: Drawn, variant: Variant) -> dict[str, Any]:
    """The layout of one variant, whole: what another one had of its own goes."""
    figure = drawn.figure
    own = {key: None for v in figure.variants for key in v.layout}
    top = TITLE + (2 * CHOOSER if len(figure.variants) > 1 else CHOOSER)
    base = {
        "template": "plotly_dark" if _is_dark() else "plotly_white",
        "paper_bgcolor": "--page",
        "plot_bgcolor": "--page",
        "title": {"text": figure.title, "y": 0.98, "yanchor": "top"},
        "height": figure.height + top,
        "margin": {"l": 60, "r": 20, "t": top, "b": 50},
        "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom"},
        "hovermode": "closest",
    }
    layout: dict[str, Any] = coloured(own | base | figure.layout | variant.layout)
    return layout


def _is_dark() -> bool:
    return "dark" in str(pio.templates.default)

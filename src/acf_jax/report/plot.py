"""Interactive figures: Plotly's own JSON beside an empty element, drawn by page.js.

A colour is named as in style.css ("--corrected"), so that one figure serves a light and a dark page.
"""

import html
import json
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from acf_jax.report.markup import Html, element, formula
from acf_jax.report.words import percent

NOMINAL = {"color": "--nominal", "dash": "dot", "width": 2}
RECALIBRATED = {"color": "--recalibrated", "dash": "dash", "width": 2}
CORRECTED = {"color": "--corrected", "width": 2.5}
CONTACT = {"color": "--contact", "dash": "longdashdot", "width": 2}
LINES = {"nominal": NOMINAL, "recalibrated": RECALIBRATED, "corrected": CORRECTED}
LEAST = 1e-6  # of a bar: Plotly writes no text beside an empty one
SYMBOLS = {"nominal": "triangle-up", "recalibrated": "square", "corrected": "circle"}


class Variant(NamedTuple):
    """What one choice of the reader shows."""

    label: str
    data: Sequence[dict[str, Any]]  # Plotly traces
    layout: dict[str, Any] = {}  # noqa: RUF012  # what of the layout belongs to this choice


class Figure(NamedTuple):
    """What a figure is drawn from."""

    title: str
    variants: Sequence[Variant]
    layout: dict[str, Any]
    height: int  # pixels
    choice: str  # label of the choice among several variants
    first: int  # the variant that is shown first


class Drawn(Html):
    """A figure as HTML that still knows what it is drawn from."""

    figure: Figure


def plot(
    name: str,
    title: str,
    caption: str,
    variants: Sequence[Variant],
    layout: dict[str, Any],
    height: int = 340,
    choice: str = "Show",
    first: int = 0,
) -> Drawn:
    """A figure; with several variants the reader chooses among them.

    **Arguments:** `name`: unique on the page. `title`: also what a screen reader says of it. `height`: in pixels.
    `choice`: label of the choice. `first`: the variant that is shown first.
    """
    content = {
        "layout": {**layout, "height": height},
        "variants": [{"data": list(v.data), "layout": v.layout} for v in variants],
    }
    parts: list[Html] = [element("h3", title)]
    if len(variants) > 1:
        options = (element("option", v.label, value=i, selected=i == first) for i, v in enumerate(variants))
        chooser = element("select", *options, id=f"{name}-choice", data_plot=name)
        parts.append(element("label", f"{choice} ", chooser, class_="choice"))
    drawing = element(
        "div",
        id=name,
        class_="plot",
        role="group",  # Plotly puts buttons into it
        aria_label=title,
        style=f"height:{height}px",
        data_first=first,
    )
    data = element("script", Html(_json(content)), type="application/json", id=f"{name}-data")
    drawn = Drawn(element("figure", *parts, drawing, data, element("figcaption", formula(caption))))
    drawn.figure = Figure(title, variants, layout, height, choice, first)
    return drawn


def bars(labels: Sequence[str], values: Sequence[float]) -> dict[str, Any]:
    """A bar for each probability, its percentage within or beside it; the last one is on top."""
    return {
        "type": "bar",
        "orientation": "h",
        "y": list(labels),
        "x": series(max(p, LEAST) for p in values),
        "marker": {"color": "--bar"},
        "text": [percent(p) for p in values],
        "textposition": ["inside" if p > 0.5 else "outside" for p in values],
        "insidetextfont": {"color": "--on-high"},
        "hoverinfo": "skip",
    }


def axis(title: str, **options: Any) -> dict[str, Any]:
    """An axis with its title."""
    return {"title": {"text": title}, **options}


def series(values: Iterable[float], digits: int = 5) -> list[float | None]:
    """Numbers for JSON: `digits` significant figures, None where there is none."""
    return [float(f"{v:.{digits}g}") if np.isfinite(v) else None for v in values]


def plain(value: object) -> str:
    """Text for Plotly, which reads some HTML."""
    return html.escape(str(value), quote=False)


def _json(content: object) -> str:
    """JSON that cannot end the script element it stands in."""
    return json.dumps(content, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")

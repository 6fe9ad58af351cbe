"""Charts as inline SVG: no script, themed by the page's CSS variables, readable at a phone's width."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape
from math import ceil, floor, isfinite, log10

WIDTH, HEIGHT = 360, 250
LEFT, RIGHT, TOP, BOTTOM = 62, 20, 10, 40

# Dark to bright, even steps in lightness, safe for colour-blind readers (a short viridis).
_RAMP = ((68, 1, 84), (65, 68, 135), (42, 120, 142), (34, 168, 132), (122, 209, 81), (253, 231, 37))


@dataclass(frozen=True)
class Series:
    """One line or set of points; `style` is 'line', 'step' or 'points'."""

    name: str
    x: Sequence[float]
    y: Sequence[float]
    colour: int
    style: str = "line"


@dataclass(frozen=True)
class Axis:
    """A label and a scale; without limits it spans the data."""

    label: str
    log: bool = False
    low: float | None = None
    high: float | None = None


def power(value: float, digits: int = 1) -> str:
    """A number as 5.8×10⁻⁷ for HTML and SVG; without the power of ten where that is shorter."""
    if value == 0:
        return "0"
    if digits and 0.1 <= abs(value) < 1000:
        return f"{value:.0f}" if abs(value) >= 100 else f"{value:.2g}"
    exponent = floor(log10(abs(value)) + 1e-12)
    mantissa = f"{value / 10.0**exponent:.{digits}f}"
    if mantissa.startswith("10"):
        exponent, mantissa = exponent + 1, f"{1:.{digits}f}"
    raised = str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"10{raised}" if digits == 0 and mantissa == "1" else f"{mantissa}×10{raised}"


def chart(title: str, series: Sequence[Series], x: Axis, y: Axis) -> str:
    """Lines and points on linear or logarithmic axes."""
    to_x, x_ticks = _scale(x, [v for s in series for v in s.x], LEFT, WIDTH - RIGHT)
    to_y, y_ticks = _scale(y, [v for s in series for v in s.y], HEIGHT - BOTTOM, TOP)
    parts = [_frame(x, y, to_x, to_y, x_ticks, y_ticks)]
    for one in series:
        points = [
            (to_x(a), to_y(b))
            for a, b in zip(one.x, one.y, strict=True)
            if (a > 0 or not x.log) and (b > 0 or not y.log)
        ]
        if one.style == "points" or len(points) == 1:  # a line of one point is not seen
            parts += [
                f'<circle class="c{one.colour} dot" cx="{a:.1f}" cy="{b:.1f}" r="4.5"/>' for a, b in points
            ]
        if one.style == "points":
            continue
        if one.style == "step":
            points = [
                corner
                for (a, b), (c, _) in zip(points, [*points[1:], points[-1]], strict=True)
                for corner in ((a, b), (c, b))
            ]
        path = "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in points)
        parts.append(f'<path class="c{one.colour} line" d="{path}"/>')
    legend = "".join(f'<span class="key k{s.colour} {s.style}">{escape(s.name)}</span>' for s in series)
    return _figure(title, legend, "".join(parts), f"{title}: {y.label} over {x.label}")


def heat_map(
    title: str, rows: Sequence[Sequence[float | None]], x: Axis, y: Axis, span: tuple[float, float]
) -> str:
    """A grid of positive values in colours of their logarithm, from span[0] to span[1]; None stays empty."""
    to_x, x_ticks = _scale(x, [], LEFT, WIDTH - RIGHT)
    to_y, y_ticks = _scale(y, [], HEIGHT - BOTTOM, TOP)
    width = (WIDTH - RIGHT - LEFT) / len(rows[0])
    height = (HEIGHT - BOTTOM - TOP) / len(rows)
    cells = [
        f'<rect x="{LEFT + j * width:.1f}" y="{HEIGHT - BOTTOM - (i + 1) * height:.1f}" '
        f'width="{width + 0.3:.1f}" height="{height + 0.3:.1f}" fill="{_colour(value, span)}">'
        f"<title>{power(value)}</title></rect>"
        for i, row in enumerate(rows)
        for j, value in enumerate(row)
        if value is not None
    ]
    return _figure(title, "", _frame(x, y, to_x, to_y, x_ticks, y_ticks) + "".join(cells), title)


def colour_bar(label: str, span: tuple[float, float]) -> str:
    """The key of the heat maps."""
    stops = ",".join(f"rgb{rgb}" for rgb in _RAMP).replace(" ", "")
    return (
        f'<div class="bar"><span>{power(span[0], 0)}</span>'
        f'<i style="background:linear-gradient(90deg,{stops})"></i>'
        f"<span>{power(span[1], 0)}</span></div><p class=note>{escape(label)}</p>"
    )


def decades(values: Sequence[float]) -> tuple[float, float]:
    """The powers of ten around positive values."""
    found = [value for value in values if value > 0] or [1.0]
    low, high = floor(log10(min(found))), ceil(log10(max(found)))
    return 10.0**low, 10.0 ** max(high, low + 1)


def _colour(value: float, span: tuple[float, float]) -> str:
    low, high = log10(span[0]), log10(span[1])
    place = (log10(max(value, span[0])) - low) / (high - low) * (len(_RAMP) - 1)
    i = min(int(place), len(_RAMP) - 2)
    mix = [round(a + (b - a) * (place - i)) for a, b in zip(_RAMP[i], _RAMP[i + 1], strict=True)]
    return f"rgb({mix[0]},{mix[1]},{mix[2]})"


def _scale(
    axis: Axis, values: Sequence[float], start: float, end: float
) -> tuple[Callable[[float], float], list[tuple[float, str]]]:
    """Value to pixel, and the ticks with their labels."""
    if axis.log:
        low, high = decades(values)
        first, last = log10(low), log10(high)
        every = max(1, ceil((last - first) / 6))
        exponents = range(round(first), round(last) + 1, every)
        ticks = [(10.0**e, power(10.0**e, 0)) for e in exponents]
        return lambda v: start + (log10(v) - first) / (last - first) * (end - start), ticks
    known = [v for v in values if isfinite(v)]
    low = axis.low if axis.low is not None else min(known)
    high = axis.high if axis.high is not None else max(known)
    if low == high:  # a single value stands in the middle
        low, high = low - (abs(low) / 2 or 1.0), high + (abs(high) / 2 or 1.0)
    step = _round_step((high - low) / 5)
    marks = [i * step for i in range(ceil(low / step - 1e-9), floor(high / step + 1e-9) + 1)]
    ticks = [(m, f"{m:,.0f}" if step >= 1000 else f"{m:.10g}") for m in marks]
    return lambda v: start + (v - low) / (high - low) * (end - start), ticks


def _round_step(step: float) -> float:
    unit = 10.0 ** floor(log10(step))
    return min((f * unit for f in (1, 2, 2.5, 5, 10)), key=lambda s: abs(s - step))


def _frame(
    x: Axis,
    y: Axis,
    to_x: Callable[[float], float],
    to_y: Callable[[float], float],
    x_ticks: list[tuple[float, str]],
    y_ticks: list[tuple[float, str]],
) -> str:
    bottom, middle = HEIGHT - BOTTOM, (TOP + HEIGHT - BOTTOM) / 2
    parts = []
    for value, label in x_ticks:
        at = to_x(value)
        parts.append(f'<line class=grid x1="{at:.1f}" x2="{at:.1f}" y1="{TOP}" y2="{bottom}"/>')
        parts.append(f'<text x="{at:.1f}" y="{bottom + 15}" text-anchor="middle">{label}</text>')
    for value, label in y_ticks:
        at = to_y(value)
        parts.append(f'<line class=grid x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{at:.1f}" y2="{at:.1f}"/>')
        parts.append(f'<text x="{LEFT - 6}" y="{at + 4:.1f}" text-anchor="end">{label}</text>')
    parts.append(
        f'<text class=label x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 6}" text-anchor="middle">'
        f"{_lowered(x.label)}</text>"
        f'<text class=label transform="translate(12 {middle}) rotate(-90)" text-anchor="middle">'
        f"{_lowered(y.label)}</text>"
    )
    return "".join(parts)


def _lowered(label: str) -> str:
    """A label with its subscripts (F_P, k_C) set low."""
    low = r'<tspan dy="3" font-size="9">\1</tspan><tspan dy="-3">&#8203;</tspan>'
    return re.sub(r"_(\w+)", low, escape(label))


def _figure(title: str, legend: str, body: str, description: str) -> str:
    keys = f'<div class="legend">{legend}</div>' if legend else ""
    return (
        f"<figure><figcaption>{escape(title)}</figcaption>{keys}"
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(description)}">{body}</svg>'
        "</figure>"
    )

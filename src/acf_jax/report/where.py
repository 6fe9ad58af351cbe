"""Where the gap lies: component, phase of the contact, condition."""

import numpy as np

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.diagnosis.where import PHASES, ConditionGap
from acf_jax.report.markup import Html, element
from acf_jax.report.plot import Variant, axis, bars, plot, series
from acf_jax.report.words import condition, has_held_out, listed, percent

ROWS = 24  # conditions that the map shows


def components(diagnosis: Diagnosis) -> Html:
    """Probability that a cause acts at each component."""
    names, shares = list(diagnosis.component)[::-1], list(diagnosis.component.values())[::-1]
    layout = {"xaxis": axis("probability that a cause acts there", range=[0, 1], tickformat=".0%")}
    caption = "Unknown causes included. Two causes at different components count at both."
    return plot("component", "At which component", caption, [Variant("", [bars(names, shares)])], layout, 240)


def gap_map(diagnosis: Diagnosis) -> Html:
    """The recalibrated model's excess squared residual by condition and phase."""
    found = diagnosis.gap_map.conditions
    if not any(c.share for c in found):
        return element(
            "p",
            "The recalibrated model leaves no more than noise and trial-to-trial spread at any condition.",
        )
    shown = sorted(sorted(found, key=lambda c: -c.share)[:ROWS], key=lambda c: (-c.f_p, -c.v_e))
    phased = any(c.phases for c in shown)
    columns = list(PHASES) if phased else ["peak"]
    values = np.array([[c.phases[name] if phased else c.share for name in columns] for c in shown])
    data = {
        "type": "heatmap",
        "x": [_span(name) for name in columns] if phased else ["whole trial"],
        "y": [condition(c.v_e, c.f_p) for c in shown],
        "z": [series(row) for row in values],
        "text": [[percent(v) if v >= 0.005 else "" for v in row] for row in values],
        "texttemplate": "%{text}",
        "customdata": [[_rms(c)] * len(columns) for c in shown],
        "hovertemplate": "%{y}<br>%{x}<br>%{z:.1%} of the gap; %{customdata} over the whole trace<extra></extra>",
        "colorscale": [[0, "--low"], [1, "--high"]],
        "zmin": 0,
        "showscale": False,
        "xgap": 2,
        "ygap": 2,
    }
    layout = {
        "xaxis": {"side": "top", "tickangle": 0, "showgrid": False, "fixedrange": True},
        "yaxis": {"showgrid": False, "fixedrange": True, "type": "category"},
        "margin": {"l": 100, "r": 4, "t": 50, "b": 6},
    }
    hidden = f" The {ROWS} conditions with the largest share are shown." if len(found) > ROWS else ""
    what = "squared error beyond noise and trial-to-trial spread" if phased else "squared error of the peak"
    units = " Phases in units of the recalibrated model's peak time t_max." if phased else ""
    seen = (
        "on conditions that the fit did not see"
        if has_held_out(diagnosis)
        else "on the one condition of the fit"
    )
    caption = f"Share of the recalibrated model's {what}, {seen}.{units}{hidden}"
    title = "In which phase, at which condition" if phased else "At which condition"
    height = 80 + 30 * len(shown)
    return plot("map", title, caption, [Variant("", [data])], layout, height)


def in_words(diagnosis: Diagnosis) -> Html:
    """The map in one sentence."""
    d = diagnosis
    parts = []
    phases = {name: share for name, share in d.gap_map.phase.items() if share}
    if phases:
        top = [n for n in sorted(phases, key=lambda name: -phases[name])[:2] if phases[n] > 0.05]
        parts.append(
            f"Of the gap, {listed([f'{percent(phases[name])} lies in the {name}' for name in top])}."
        )
    worst = max(d.gap_map.conditions, key=lambda c: c.share)
    if worst.share:
        parts.append(
            f"The condition that contributes most is {condition(worst.v_e, worst.f_p)} ({percent(worst.share)};"
            f" {_rms(worst)})."
        )
    return element("p", " ".join(parts)) if parts else Html("")


def _span(name: str) -> str:
    low, high = PHASES[name]
    if np.isinf(high):
        return f"{name}<br>from {low:g}"
    return f"{name}<br>to {high:g}"


def _rms(c: ConditionGap) -> str:
    return "no force figure" if c.excess_rms_n is None else f"{c.excess_rms_n:.2g} N RMS"

"""How far the gap shrinks on conditions that the fit did not see."""

from typing import Any

import numpy as np

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.report.markup import Html, element, join, table
from acf_jax.report.plot import LINES, SYMBOLS, Variant, axis, plot, series
from acf_jax.report.words import MODELS, condition, headed, of_removed, percent, si

STEPS = list(MODELS)


def force_error(content: dict[str, Any]) -> Html | None:
    """Force error of the three models against the noise floor; None without traces."""
    gap = content["gap"]
    values = [gap[name]["force_rms_n"] for name in STEPS]
    if None in values:
        return None
    bars = {
        "type": "bar",
        "x": STEPS,
        "y": values,
        "text": [f"{v:.3g} N" for v in values],
        "textposition": "outside",
        "cliponaxis": False,
        "marker": {"color": [LINES[name]["color"] for name in STEPS]},
        "hoverinfo": "skip",
        "showlegend": False,
    }
    floor = gap["noise_floor_rms_n"]
    line = {
        "type": "scatter",
        "x": STEPS,
        "y": [floor] * len(STEPS),
        "mode": "lines",
        "line": {"color": "--measured", "dash": "dash", "width": 2},
        "name": f"noise and trial-to-trial spread, {si(floor, 3, 'N')}",
        "hoverinfo": "skip",
    }
    layout = {"yaxis": axis("RMS force error / N", rangemode="tozero"), "showlegend": True}
    caption = "Each condition predicted by a fit to the others. No model can get below the dashed line."
    return plot("force-error", "Force error", caption, [Variant("", [bars, line])], layout)


def peak_errors(diagnosis: Diagnosis) -> Html | None:
    """Error of each trial's peak over contact velocity; None where no condition is held out."""
    d = diagnosis
    if d.gap["recalibrated"].peak_rms_percent is None:
        return None
    o = d.observations
    data = []
    for name in LINES:
        held = d.held[name]
        relative = 100 * held.peak_error
        data.append(
            {
                "type": "scatter",
                "mode": "markers",
                "x": series(o.v_e),
                "y": series(relative, 3),
                "name": name,
                "marker": {
                    "color": LINES[name]["color"],
                    "symbol": SYMBOLS[name],
                    "size": 8,
                    "opacity": 0.85,
                },
                "text": [condition(v, f) for v, f in zip(o.v_e, o.f_p, strict=True)],
                "hovertemplate": "%{text}: %{y:+.2f} %<extra></extra>",
            }
        )
    layout = {
        "xaxis": axis("contact velocity / (m/s)"),
        "yaxis": axis("error of the peak / %", zeroline=True, zerolinecolor="--muted"),
    }
    caption = "One mark a trial and model, predicted by a fit that did not see the trial's condition."
    return plot("peak-error", "Error of the peak", caption, [Variant("", data)], layout)


def in_words(content: dict[str, Any]) -> Html:
    """The figures and the shrinkage."""
    gap = content["gap"]
    rows = [
        (
            join([element("strong", headed(name)), f", {MODELS[name]}"]),
            _figure(gap[name]["force_rms_n"], "N"),
            _figure(gap[name]["peak_rms_percent"], "%"),
            _figure(gap[name]["peak_max_percent"], "%"),
        )
        for name in STEPS
    ]
    head = ("Model", "RMS force error", "RMS peak error", "Largest peak error")
    sentences = []
    for name, what in (("force", "force error (noise removed)"), ("peak", "peak error")):
        shrinkage = content["shrinkage"][name]
        if shrinkage:
            grows = ": it grows" if shrinkage["value"] < 0 else ""
            sentences.append(
                f"Shrinkage of the {what} from the recalibrated to the corrected model:"
                f" {percent(shrinkage['value'])} ({of_removed(*shrinkage['ci95'])}){grows}."
            )
    if not sentences:
        alone = gap["recalibrated"]["force_rms_n"] is None and gap["recalibrated"]["peak_rms_percent"] is None
        why = "all trials have one condition, so none is held out" if alone else "there is no gap to shrink"
        if content["corrected_is_better"] is False and not alone:
            why = "the corrected model is not better than the recalibrated one there"
        sentences = [f"No shrinkage is stated: {why}."]
    return join(
        [element("p", " ".join(sentences)), table("On conditions that the fit did not see", head, rows)]
    )


def _figure(value: float | None, unit: str) -> str:
    return "–" if value is None or not np.isfinite(value) else f"{value:.3g} {unit}"

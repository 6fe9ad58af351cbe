"""Measured and predicted force over time, before and after the correction."""

from typing import Any

import numpy as np

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.report.markup import Html
from acf_jax.report.outlook import Outlook
from acf_jax.report.plot import CONTACT, LINES, Variant, axis, plot, series
from acf_jax.report.words import condition, has_held_out

MOST = 60  # trials that the page carries; the others are in the data set


def overlay(diagnosis: Diagnosis, look: Outlook) -> Html | None:
    """The traces with a choice of trial, the largest gap first shown; None without traces."""
    d = diagnosis
    o = d.observations
    gaps = np.sqrt((d.held["recalibrated"].residual ** 2).sum(1) / np.maximum(o.used.sum(1), 1))
    rows = [i for i in np.argsort(-gaps) if not o.peak_only[i]][:MOST]
    if not rows:
        return None
    first = int(rows[0])
    rows.sort()
    variants = [_trial(d, look, int(i), float(gaps[i])) for i in rows]
    left_out = [name for name in d.excluded if _trace(d, name) is not None]
    variants += [_excluded(d, name) for name in left_out[:MOST]]
    layout = {
        "xaxis": axis("time since first contact / ms", domain=[0, 1], anchor="y2"),
        "yaxis": axis("sensed force / N", domain=[0.4, 1]),
        "yaxis2": axis("measured − model / N", domain=[0, 0.32]),
    }
    more = f" The {MOST} trials with the largest gap can be chosen." if (~o.peak_only).sum() > MOST else ""
    by = (
        "by a fit that did not see the trial's condition; the contact force by the fit to all trials"
        if has_held_out(d)
        else "by the fit to all trials: they have one condition, so none is held out"
    )
    moved = " The robot moves as measured, but for the contact force." if o.robot else ""
    caption = (
        f"Every curve is predicted at the commanded velocity and pretension, {by}.{moved} Nominal: the paper's model"
        " with the rig's nominal parameters; recalibrated: the same refitted. Below: what each model misses; the band"
        f" is ± 2 standard deviations of the noise. A click on the legend hides a curve.{more}"
    )
    title = "Measured and predicted force"
    return plot("overlay", title, caption, variants, layout, 520, "Trial", rows.index(first))


def _trial(d: Diagnosis, look: Outlook, i: int, gap: float) -> Variant:
    o = d.observations
    used = o.used[i]
    time = series(1e3 * o.time[i, used], 4)
    traces: list[dict[str, Any]] = []
    for name, line in LINES.items():
        residual = d.held[name].residual[i, used]
        shared = {"x": time, "mode": "lines", "line": line, "name": name, "legendgroup": name}
        traces.append({**shared, "y": series(o.force[i, used] - residual)})
        traces.append({**shared, "y": series(residual, 4), "yaxis": "y2", "showlegend": False})
    at = look.trials[o.names[i]]
    fitted = d.corrected if look.which == "corrected" else d.fits[0]
    inside = at.time <= o.time[i, used].max()
    # a sensor that only reads changes nothing at the contact: then the two forces are one curve
    apart = float(np.abs(at.force - at.contact_force)[inside].max()) > 1e-6 * at.peak_force
    traces.append(
        {
            "x": series(1e3 * (at.time[inside] + fitted.common[1]), 4),
            "y": series(at.contact_force[inside]),
            "mode": "lines",
            "line": CONTACT,
            "name": f"contact force, {look.which}" if apart else "contact force (same as sensed)",
            "visible": True if apart else "legendonly",
        }
    )
    traces.append(_measured(time, o.force[i, used]))
    band = {
        "type": "rect", "xref": "paper", "x0": 0, "x1": 1, "yref": "y2",
        "y0": -2 * o.noise.std, "y1": 2 * o.noise.std, "fillcolor": "--band", "line": {"width": 0}, "layer": "below",
    }  # fmt: skip
    label = f"{o.names[i]}: {condition(o.v_e[i], o.f_p[i])}, recalibrated model off by {gap:.2g} N RMS"
    return Variant(label, traces, {"shapes": [band]})


def _excluded(d: Diagnosis, name: str) -> Variant:
    trial = next(t for t in d.dataset.trials if t.name == name)
    assert trial.trace is not None
    label = f"{name}: {condition(trial.contact_velocity, trial.pretension)}, left out"
    return Variant(label, [_measured(series(1e3 * trial.trace.time, 4), trial.trace.force)])


def _measured(time: list[float | None], force: np.ndarray) -> dict[str, Any]:
    marker = {"color": "--measured", "size": 5 if len(time) < 150 else 3}
    return {
        "x": time,
        "y": series(force),
        "mode": "markers",
        "marker": marker,
        "name": "measured",
        "legendrank": 1,
    }


def _trace(d: Diagnosis, name: str) -> object:
    return next((t.trace for t in d.dataset.trials if t.name == name), None)

"""Sensed against contact force: peaks over contact velocity, and at each condition."""

import numpy as np

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.diagnosis.heldout import largest_reading
from acf_jax.gap_model import Which
from acf_jax.inference.observations import Observations
from acf_jax.inference.ring import ringing
from acf_jax.predict import Prediction
from acf_jax.report.markup import Html, details, element, table
from acf_jax.report.outlook import Curves, Outlook
from acf_jax.report.plot import CONTACT, LINES, Variant, axis, plain, plot, series
from acf_jax.report.words import condition, headed, percent

NOISE = "what noise adds to the largest sample of a trace"


def over_velocity(diagnosis: Diagnosis, look: Outlook) -> Html:
    """Peak force over contact velocity with a choice of pretension, in N and against the nominal model."""
    which = look.which
    variants = [
        _variant(diagnosis, curves, which, relative) for relative in (False, True) for curves in look.curves
    ]
    layout = {"xaxis": axis("contact velocity / (m/s)")}
    noisy = "" if diagnosis.observations.peak_only.all() else f" All but it hold {NOISE}."
    caption = (
        f"{headed(which)}, sensed: what the sensor reads. {headed(which)}, contact: what acts between robot and flange;"
        f" judge safety by it.{noisy} The band is ± 2 standard deviations of the {which} contact peak. Between the"
        " tried velocities the models interpolate."
    )
    title = "Peak force over contact velocity"
    return plot("peaks", title, caption, variants, layout, 400, "Pretension", len(look.curves) // 2)


def _variant(d: Diagnosis, curves: Curves, which: Which, relative: bool) -> Variant:
    v = series(curves.v_e, 4)
    mode = "lines" if len(v) > 1 else "markers"
    told = curves.by_model[which]
    o = d.observations
    read = (lambda p: p.peak_force) if o.peak_only.all() else (lambda p: _reading(p, o))
    sensed = {name: np.array([read(p) for p in curves.by_model[name]]) for name in LINES}
    noise_free = np.array([p.peak_force for p in curves.by_model["nominal"]])

    def shown(force: np.ndarray, nominal: np.ndarray, at: np.ndarray = curves.v_e) -> list[float | None]:
        return series(100 * (force / np.interp(at, curves.v_e, nominal) - 1) if relative else force)

    peak, std = (np.array([getattr(p, f"contact_peak_force{x}") for p in told]) for x in ("", "_std"))
    band = {
        "x": [*v, *v[::-1]],
        "y": shown(peak + 2 * std, noise_free) + shown(np.maximum(peak - 2 * std, 0), noise_free)[::-1],
        "fill": "toself",
        "fillcolor": "--band",
        "mode": "lines",
        "line": {"width": 0},
        "hoverinfo": "skip",
        "showlegend": False,
    }
    data = [band]
    for name, line in LINES.items():
        if name == "corrected" != which:
            continue  # no corrected peak is stated where it is no better
        label = f"{which}, sensed" if name == which else name
        data.append(
            {"x": v, "y": shown(sensed[name], sensed["nominal"]), "mode": mode, "line": line, "name": label}
        )
    data.append(
        {"x": v, "y": shown(peak, noise_free), "mode": mode, "line": CONTACT, "name": f"{which}, contact"}
    )
    o = d.observations
    here = np.isclose(o.f_p, curves.f_p, rtol=0.02)
    measured = d.held["corrected"].measured_peak[here]
    data.append(
        {
            "x": series(o.v_e[here], 4),
            "y": shown(measured, sensed["nominal"], o.v_e[here]),
            "mode": "markers",
            "marker": {"color": "--measured", "size": 7, "symbol": "x-thin-open", "line": {"width": 2}},
            "name": "measured",
            "text": [
                f"{plain(name)}: {force:.1f} N"
                for name, force in zip(np.array(o.names)[here], measured, strict=True)
            ],
            "hovertemplate": "%{text}<extra></extra>",
        }
    )
    if relative:
        return Variant(
            f"{curves.f_p:g} N, against nominal", data, {"yaxis": axis("peak against nominal model / %")}
        )
    return Variant(f"{curves.f_p:g} N", data, {"yaxis": axis("peak force / N", rangemode="tozero")})


def by_condition(diagnosis: Diagnosis, look: Outlook) -> Html:
    """Measured, sensed and contact peak of each condition."""
    d = diagnosis
    o = d.observations
    measured = d.held["corrected"].measured_peak
    rows = []
    for number in np.unique(o.condition):
        here = np.flatnonzero(o.condition == number)
        at = look.trials[o.names[here[0]]]
        sensed = np.mean([at.peak_force if o.peak_only[i] else _reading(at, o) for i in here])
        rows.append(
            (
                condition(o.v_e[here[0]], o.f_p[here[0]]),
                _mean(measured[here]),
                f"{sensed:.1f} ± {at.peak_force_std:.1f} N",
                f"{at.contact_peak_force:.1f} ± {at.contact_peak_force_std:.1f} N",
                percent(round(_reads(at), 3) + 0.0, 1, signed=True),
                f"{1e3 * at.peak_time:.2f} ms",
            )
        )
    head = ("Condition", "Measured", "Sensed", "At the contact", "Sensor reads", "Peak after")
    said = f"{headed(look.which)} model, ± one standard deviation"
    said += "" if o.peak_only.all() else f"; measured and sensed hold {NOISE}"
    return details("Peaks at each condition", table(said, head, rows))


def _mean(peaks: np.ndarray) -> str:
    """Measured peaks of one condition; those of a force that is cut off are not known."""
    known = peaks[np.isfinite(peaks)]
    if not known.size:
        return "cut off"
    return f"{known.mean():.1f} N" + (f" (mean of {known.size})" if known.size > 1 else "")


def _reading(at: Prediction, o: Observations) -> float:
    """The largest sample that a trace is expected to hold, as the held-out errors have it, N."""
    rings = ringing(o.rings, at.time[None], np.array([at.peak_force]))[0]
    return largest_reading(at.force, o.noise.std, rings)


def _reads(at: Prediction) -> float:
    """By which share the sensor's peak lies above the contact's; 0 where nothing touches."""
    return at.peak_force / at.contact_peak_force - 1 if at.contact_peak_force > 0 else 0.0


def in_words(look: Outlook) -> Html:
    """Whether the sensor reads the peak that acts at the contact."""
    worst = max(map(_reads, look.trials.values()), key=abs, default=0.0)
    if abs(worst) < 0.005:
        return element("p", "Within half a percent the sensor reads the peak that acts at the contact.")
    word = "low" if worst < 0 else "high"
    return element(
        "p",
        f"In the {look.which} model the sensor reads the peak up to {100 * abs(worst):.1f} % too {word}: compare models"
        " with data by the sensed force, and judge safety by the contact force.",
    )

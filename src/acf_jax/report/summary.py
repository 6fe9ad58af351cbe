"""The head of the report: the verdict, what it means for peak force and speed, and the figures to remember."""

from typing import Any

import numpy as np

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.report.markup import Html, element, join
from acf_jax.report.outlook import Curves, Outlook
from acf_jax.report.trusted import trusted
from acf_jax.report.words import (
    VERDICTS,
    advice,
    likelihood,
    name_of,
    of_removed,
    percent,
    shrunk,
    si,
    trust,
    verdict,
)


def summary(diagnosis: Diagnosis, content: dict[str, Any], look: Outlook) -> Html:
    """The head of the page."""
    d = diagnosis
    tag, mood = VERDICTS[d.verdict]
    says = verdict(d).split(": ", 1)[-1]
    headline = element("p", element("span", f"{tag}: ", class_=f"tag {mood}"), says, class_="verdict")
    kept = len(d.observations.names)
    about = (
        f"{kept} of {len(d.dataset.trials)} trials at {len(np.unique(d.observations.condition))} conditions"
    )
    title = element("h1", "Sim-to-real gap of an active contact flange")
    described = element("p", d.dataset.description or "no description", " · ", about, class_="muted")
    return join(
        [
            title,
            trusted(trust(d)),
            headline,
            element("p", f"{shrunk(d)} {consequence(d, look)}".strip()),
            element("p", advice(d)) if advice(d) else join([]),
            _tiles(d, content),
            described,
        ]
    )


def consequence(diagnosis: Diagnosis, look: Outlook) -> str:
    """What the corrected model changes about the peak force and the speed that keeps it, where it is better."""
    d = diagnosis
    if d.comparison and not d.comparison.tells_peak:
        return ""
    curves = look.curves[len(look.curves) // 2]
    nominal, corrected = curves.by_model["nominal"][-1], curves.by_model["corrected"][-1]
    v, limit, force = float(curves.v_e[-1]), nominal.contact_peak_force, corrected.contact_peak_force
    std = corrected.contact_peak_force_std
    better = "recalibrated" if d.verdict == "no_gap" else "corrected"
    sensed = ""
    if abs(corrected.peak_force / force - 1) > 0.005:
        sensed = f", of which the sensor reads {corrected.peak_force:.0f} N"
    text = (
        f"At {v:.3g} m/s and {curves.f_p:.3g} N pretension the paper's model with nominal parameters predicts a peak of"
        f" {limit:.0f} N at the contact; the {better} model gives {force:.0f} ± {si(std, 1)} N"
        f" ({percent(force / limit - 1, signed=True)}){sensed}.{_speed(curves, limit)}"
    )
    if d.verdict == "insufficient_data":
        text += " Take the corrected model as a fit to these trials, not as an explanation."
    if d.verdict == "ambiguous":
        text += " The ± holds the spread between the explanations that still stand."
    return text


def _speed(curves: Curves, limit: float) -> str:
    """At which velocity the corrected model reaches a contact force; no advice, since half of all peaks are higher."""
    force = np.array([p.contact_peak_force for p in curves.by_model["corrected"]])
    if np.abs(force[-1] / limit - 1) < 0.005 or not force[0] < limit < force[-1]:
        return ""
    v = float(np.interp(limit, np.maximum.accumulate(force), curves.v_e))
    return (
        f" It reaches {limit:.0f} N at {v:.2g} m/s already. That has no margin: the command speed tells the velocity"
        " that keeps a limit with a stated probability."
    )


def _tiles(d: Diagnosis, content: dict[str, Any]) -> Html:
    gap = content["gap"]
    before, after, floor = gap["recalibrated"], gap["corrected"], gap["noise_floor_rms_n"]
    best = d.scored[0]
    tiles = [
        (
            "Most probable",
            percent(best.probability),
            f"{name_of(best.explanation)}: {likelihood(best.probability)}",
        )
    ]
    if None not in (before["force_rms_n"], after["force_rms_n"]):
        tiles.append(
            (
                "Force error on held-out conditions",
                f"{before['force_rms_n']:.3g} → {after['force_rms_n']:.3g} N",
                f"RMS, recalibrated → corrected; noise and spread {si(floor, 3, 'N')}",
            )
        )
    if None not in (before["peak_rms_percent"], after["peak_rms_percent"]):
        tiles.append(
            (
                "Peak error on held-out conditions",
                f"{before['peak_rms_percent']:.2g} → {after['peak_rms_percent']:.2g} %",
                f"RMS; at worst {after['peak_max_percent']:.2g} % after correction",
            )
        )
    for name, what in (("force", "force"), ("peak", "peak")):
        shrinkage = content["shrinkage"][name]
        if shrinkage is not None:
            tiles.append(
                (
                    f"Gap removed, {what}",
                    percent(shrinkage["value"]),
                    of_removed(*shrinkage["ci95"]),
                )
            )
    return element("dl", *(_tile(*tile) for tile in tiles), class_="tiles")


def _tile(name: str, value: str, note: str) -> Html:
    return element(
        "div", element("dt", name), element("dd", value, class_="value"), element("dd", note, class_="muted")
    )

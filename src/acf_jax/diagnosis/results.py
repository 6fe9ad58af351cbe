"""What a diagnosis leaves for other programs: `diagnosis.json` and `model.json`."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any, cast

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from acf_jax.dataset.description import LowPassForm
from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.diagnosis.document import document
from acf_jax.diagnosis.experiment import Experiment
from acf_jax.diagnosis.verdict import shows_nothing
from acf_jax.files import write_text
from acf_jax.gap_model import (
    LATEST_S,
    SCHEMA,
    GapModel,
    Lack,
    Proposed,
    Variant,
    Verdict,
    forms,
    write_model,
)
from acf_jax.inference.fit import Fit
from acf_jax.inference.parameters import delays, parameters
from acf_jax.provenance import PROGRAM

CARRIED = 0.02  # explanations below this probability do not count in the spread of predictions


def write_results(folder: Path, diagnosis: Diagnosis) -> dict[str, Any]:
    """Write both files into `folder`; returns the content of `diagnosis.json`."""
    content = document(diagnosis)
    write_text(folder / "model.json", write_model(gap_model(diagnosis)))
    write_text(folder / "diagnosis.json", json.dumps(content, indent=1) + "\n")
    return content


def variant(fitted: Fit, probability: float) -> Variant:
    """A fit as it is written."""
    count, late = len(fitted.physical), float(np.clip(fitted.common[1], -LATEST_S, LATEST_S))
    covariance = fitted.covariance[:count, :count]
    return Variant(
        effects=fitted.explanation,
        probability=min(max(probability, 0.0), 1.0),
        names=tuple(name for name, _ in parameters(fitted.explanation)),
        theta=tuple(fitted.physical.tolist()),
        covariance=tuple(tuple(row) for row in covariance.tolist()),
        # the delay of the triggers belongs to the recording, but for a sensor that is late anyway
        forms=forms(fitted.explanation),
        delay_s=late if delays(fitted.explanation) else 0.0,
    )


def gap_model(diagnosis: Diagnosis) -> GapModel:
    """The model that a diagnosis leaves."""
    d = diagnosis
    of = {f.explanation: p for f, p in zip(d.fits, d.probability, strict=True)}
    standing = [
        f
        for f in d.fits
        if f is not d.corrected and of[f.explanation] > CARRIED and d.told.stated(f.explanation) in d.credible
    ]
    o = d.observations
    return GapModel(
        schema=SCHEMA,
        description=d.dataset.description,
        nominal=variant(d.nominal, 0.0).model_copy(update={"covariance": _known(o.prior.stds)}),
        recalibrated=variant(d.fits[0], of[()]),
        corrected=variant(d.corrected, of[d.corrected.explanation]),
        alternatives=tuple(variant(f, of[f.explanation]) for f in standing),
        peak_form_error=d.form_error["corrected"],
        step_s=min(f.grid.h for f in (d.corrected, *standing)),
        sample_rate_hz=float(1 / np.median(o.intervals)) if o.intervals.size else 10e3,
        v_range=(float(o.v_e.min()), float(o.v_e.max())),
        f_p_range=(float(o.f_p.min()), float(o.f_p.max())),
        corners=_corners(o.v_e, o.f_p),
        rel_std=o.rel_std,
        low_pass=LowPassForm(**asdict(o.low_pass)) if o.low_pass else None,
        tool_mass_kg=o.tool_mass,
        verdict=cast(Verdict, d.verdict),
        shown_closer=_shown_closer(d),
        better=None if d.comparison is None else d.comparison.is_better,
        recalibrated_form_error=d.form_error["recalibrated"],
        lack=_lack(d),
        next_experiment=_proposed(d.next_experiment),
        made_by=PROGRAM,
        data_sha256=d.dataset.digest,
    )


def _lack(d: Diagnosis) -> Lack | None:
    """What too little data are short of."""
    if d.verdict != "insufficient_data":
        return None
    return shows_nothing(d.scored[0].explanation, d.detectability, d.observations) or "separation"


def _proposed(e: Experiment | None) -> Proposed | None:
    if e is None:
        return None
    return Proposed(contact_velocity_m_per_s=e.v_e, pretension_n=e.f_p, repeats=e.repeats)


def _shown_closer(d: Diagnosis) -> bool | None:
    """Whether the 95 % interval of the shrinkage lies above zero; None where nothing is corrected."""
    if not d.corrected.explanation:
        return None
    shrinkage = d.shrinkage_force if d.observations.traced.any() else d.shrinkage_peak
    return shrinkage is not None and shrinkage.ci95[0] > 0


def _known(stds: np.ndarray) -> tuple[tuple[float, ...], ...]:
    """The covariance of the rig's parameters before any trial."""
    return tuple(tuple(row) for row in np.diag(np.square(stds)).tolist())


def _corners(v_e: np.ndarray, f_p: np.ndarray) -> tuple[tuple[float, float], ...]:
    """The corners of the region that the trials' conditions enclose: of a polygon, or the ends of a line."""
    points = np.unique(np.column_stack([v_e, f_p]), axis=0)  # in order: the ends of a line are first and last
    try:
        chosen = points[np.sort(ConvexHull(points / np.maximum(points.max(0), 1e-12)).vertices)]
    except (QhullError, ValueError):  # no area
        chosen = points[[0, -1]]
    return tuple((float(v), float(f)) for v, f in chosen)

"""`report.html`: one self-contained page, the answer first."""

from pathlib import Path
from typing import Any

from acf_jax import __version__
from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.diagnosis.results import write_results
from acf_jax.files import write_text
from acf_jax.folders import whole_folder
from acf_jax.provenance import Origin
from acf_jax.report import (
    causes,
    composition,
    design,
    discrepancy,
    evidence,
    heldout,
    motion,
    parameters,
    peaks,
    quality,
    scatter,
    summary,
    traces,
    where,
)
from acf_jax.report.markup import element
from acf_jax.report.outlook import outlook
from acf_jax.report.page import page, part


def save_diagnosis(folder: Path, diagnosis: Diagnosis, origin: Origin) -> dict[str, Any]:
    """Write diagnosis.json, model.json, report.html and provenance.json into `folder`, all or none.

    **Returns:** the content of diagnosis.json.
    """
    with whole_folder(folder) as scratch:
        content = write_results(scratch, diagnosis)
        write_report(scratch / "report.html", diagnosis, content, str(origin))
        origin.write(scratch)
    return content


def write_report(path: Path, diagnosis: Diagnosis, content: dict[str, Any], origin: str = "") -> None:
    """Write the page of a diagnosis.

    **Arguments:** `path`: of the HTML file. `content`: of `diagnosis.json`, whose figures the page shows. `origin`:
    how it came about.
    """
    d = diagnosis
    look = outlook(d)
    beside = [p for p in (heldout.force_error(content), heldout.peak_errors(d)) if p is not None]
    parts = [
        part(
            "made-of", "Made of", "What the gap is made of", composition.in_words(d), composition.bars(d),
            composition.figures(d), causes.switched(d),
        ),
        part("before-after", "Before, after", "Before and after", traces.overlay(d, look), motion.robot_motion(d)),
        part("where", "Where", "Where the gap lies", where.in_words(d), where.gap_map(d), where.components(d)),
        part(
            "why", "Why", "What explains it", evidence.in_words(d), evidence.probabilities(content),
            discrepancy.unknown_cause(d), evidence.tried(d),
        ),
        part(
            "how-far", "How far it shrinks", "How far the gap shrinks", heldout.in_words(content),
            element("div", *beside, class_="beside"), scatter.in_words(d), scatter.by_frequency(d),
        ),
        part(
            "peak", "Peak force", "Sensed and contact force", peaks.in_words(look), peaks.over_velocity(d, look),
            peaks.by_condition(d, look),
        ),
        part("parameters", "Parameters", "Parameters", parameters.parameter_table(d)),
        part("next", "Next trial", "What to measure next", design.next_experiment(d)),
        part("design", "Detectability", "What these trials could have seen", design.detectable(d)),
        part("data", "Data", "Data quality", quality.overview(d)),
        part("warnings", "Warnings", "Warnings", quality.warnings(d)),
    ]  # fmt: skip
    foot = element(
        "p",
        f"acf-jax {__version__}. The figures are those of diagnosis.json beside this page; ‘held-out conditions’ means"
        " cross-validation by condition. SI units; positive x compresses the flange; time 0 is first contact."
        f" {origin or f'Data set {d.dataset.folder.name}, SHA-256 {d.dataset.digest[:12]}.'}",
        class_="muted",
    )
    title = f"Sim-to-real gap: {d.dataset.folder.name}"
    write_text(path, page(title, summary.summary(d, content, look), [p for p in parts if p], foot))

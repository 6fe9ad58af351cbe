"""Draw docs/figures/flange_tests.svg and docs/figures/table1_diagnosis.svg: what `diagnose` makes of measured impacts.

python docs/figures/measured.py [FOLDER]

FOLDER is a gap data set of the flange tests; they are not part of this repository, docs/real_data.md says where they
come from. Without it only the picture of Table 1 is drawn, from configs/table1.csv.
"""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from acf_jax.dataset import GapDataset, Measurement, Prior, RigPrior, Trial, read_dataset
from acf_jax.diagnosis import Diagnosis, diagnose
from acf_jax.evidence.posterior import UNKNOWN
from acf_jax.inference.parameters import Explanation, label
from acf_jax.start import start_jax

HERE = Path(__file__).parent
INK, GREY = "#1f2937", "#9ca3af"
MODELS = {"recalibrated": "#2563eb", "corrected": "#d9480f"}
BEFORE, AFTER = 2.0, 0.6  # ms of a trace that are shown beside what is compared
SHOWN = 5  # explanations


def read_table_1() -> GapDataset:
    """The paper's five measured peaks with wide priors, since the rig is not published."""
    path = HERE.parents[1] / "configs/table1.csv"
    rows = np.genfromtxt(path, delimiter=",", skip_header=1, usecols=(1, 2, 3))
    priors = Prior(4.0, 2.0), Prior(80.0, 80.0), Prior(5e3, 5e3), Prior(1.8e5, 1.5e5)
    trials = tuple(Trial(f"{v_e} m/s", v_e, f_p, peak) for v_e, f_p, peak in rows.tolist())
    return GapDataset(path.parent, "Table 1 of the paper", RigPrior(*priors), Measurement(1.0), trials)


def name_of(explanation: Explanation) -> str:
    """An explanation as a person would write it."""
    return "nothing in the library" if explanation == UNKNOWN else label(explanation)


def draw_trial(panel: Axes, d: Diagnosis, i: int) -> None:
    """The measured samples, and what the two models say that did not see this trial's condition."""
    o = d.observations
    used = o.used[i]
    trace = next(t.trace for t in d.dataset.trials if t.name == o.names[i])
    assert trace is not None
    time, end = 1e3 * trace.time, 1e3 * o.time[i, used].max() + AFTER
    shown = (time >= -BEFORE) & (time <= end + 4)
    panel.plot(time[shown], trace.force[shown], "-", color=GREY, linewidth=0.8)
    panel.plot(time[shown], trace.force[shown], "o", color=GREY, markersize=3)
    panel.plot(1e3 * o.time[i, used], o.force[i, used], "o", color=INK, markersize=4, zorder=4)
    for name, colour in MODELS.items():
        predicted = o.force[i, used] - d.held[name].residual[i, used]
        panel.plot(1e3 * o.time[i, used], predicted, color=colour, linewidth=1.8)
    title = f"{o.v_e[i]:.2f} m/s, {o.f_p[i]:.0f} N"
    panel.set_title(title, loc="left", fontsize=10, color=INK, pad=4)


def draw_probabilities(panel: Axes, d: Diagnosis) -> None:
    """The most probable explanations as bars."""
    first = d.scored[:SHOWN]
    rows = np.arange(len(first))
    panel.barh(rows, [s.probability for s in first], height=0.55, color=MODELS["recalibrated"])
    for row, s in enumerate(first):
        panel.text(s.probability + 0.015, row, f"{s.probability:.2g}", va="center", fontsize=9.5, color=INK)
    panel.set_yticks(rows, [name_of(s.explanation) for s in first])
    panel.invert_yaxis()
    panel.set(xlim=(0, 1.12), xticks=(0, 0.5, 1), xlabel="probability")
    panel.set_title("What explains the gap", loc="left", fontsize=11, color=INK)


def draw_flange_tests(d: Diagnosis) -> None:
    """One panel a trial, then the error on held-out conditions and the probabilities."""
    o = d.observations
    order = sorted(range(len(o.names)), key=lambda i: (round(float(o.v_e[i]), 2), o.f_p[i]))
    figure = plt.figure(figsize=(10, 7.6), layout="constrained")
    upper, lower = figure.subfigures(2, 1, height_ratios=(1.9, 1), squeeze=False)[:, 0]
    columns = len(order) // 2
    panels = upper.subplots(2, columns, sharex=True, sharey=True)
    for panel, i in zip(panels.flat, order, strict=True):
        draw_trial(panel, d, i)
    for row in panels:
        row[0].set_ylabel("sensed force, N")
    for panel in panels[-1]:
        panel.set_xlabel("time since contact, ms")
    key = panels[0, -1]
    for y, text, colour in (
        (0.95, "measured, compared", INK),
        (0.85, "measured, not compared", "#6b7280"),
        (0.75, "recalibrated, this condition held out", MODELS["recalibrated"]),
        (0.65, f"corrected ({name_of(d.corrected.explanation)})", MODELS["corrected"]),
    ):
        key.text(0.98, y, text, transform=key.transAxes, ha="right", color=colour, fontsize=8.5)
    error, probability = lower.subplots(1, 2, width_ratios=(1, 1.1))
    draw_errors(error, d)
    draw_probabilities(probability, d)
    figure.savefig(HERE / "flange_tests.svg", metadata={"Date": None})
    plt.close(figure)


def draw_errors(panel: Axes, d: Diagnosis) -> None:
    """Force error of the three models on held-out conditions, over what no model could predict."""
    values = {name: figures.force_rms_n or 0.0 for name, figures in d.gap.items()}
    colours = [GREY, *MODELS.values()]
    rows = np.arange(len(values))
    panel.barh(rows, list(values.values()), height=0.55, color=colours)
    for row, value in enumerate(values.values()):
        panel.text(value + 0.01 * max(values.values()), row, f" {value:.1f} N", va="center", fontsize=9.5)
    if d.noise_floor_rms_n:
        panel.axvline(d.noise_floor_rms_n, color=INK, linewidth=1.2, linestyle=(0, (4, 2)))
        floor = f"dashed: floor {d.noise_floor_rms_n:.1f} N"
        panel.text(1.0, 1.04, floor, transform=panel.transAxes, ha="right", fontsize=9, color=INK)
    panel.set_yticks(rows, ["paper's model, nominal", "recalibrated", "corrected"])
    panel.set(xlim=(0, 1.2 * max(values.values())), xlabel="RMS error of the force on held-out conditions, N")
    panel.invert_yaxis()
    panel.set_title("How far the gap shrinks", loc="left", fontsize=11, color=INK, pad=14)


def draw_peaks(d: Diagnosis) -> None:
    """Error of each peak as predicted without it, and the probabilities."""
    o = d.observations
    figure, (error, probability) = plt.subplots(
        1, 2, figsize=(10, 3.6), width_ratios=(1.25, 1), layout="constrained"
    )
    measured = d.held["recalibrated"].measured_peak
    noise = 100 * o.noise.std / measured
    error.fill_between(o.v_e, -2 * noise, 2 * noise, color=GREY, alpha=0.3, linewidth=0)
    error.axhline(0, color=INK, linewidth=0.8)
    refitted = 100 * (d.held["recalibrated"].peak / measured - 1)
    error.plot(o.v_e, refitted, "o-", color=MODELS["recalibrated"], markersize=6, linewidth=1.2)
    error.text(
        0.98, 0.05, f"recalibrated on the other speeds: {d.gap['recalibrated'].peak_rms_percent:.2f} % (RMS)",
        transform=error.transAxes, ha="right", color=MODELS["recalibrated"], fontsize=9.5,
    )  # fmt: skip
    error.text(0.98, 0.93, "± 2 standard deviations of 1 N noise", transform=error.transAxes, ha="right",
               color="#6b7280", fontsize=9.5)  # fmt: skip
    top = 1.25 * max(np.abs(refitted).max(), 2 * noise.max())
    error.set(ylim=(-top, top), xlabel="contact velocity, m/s", ylabel="error of the peak force, %")
    error.set_title("Each speed predicted without it", loc="left", fontsize=11, color=INK)
    draw_probabilities(probability, d)
    figure.savefig(HERE / "table1_diagnosis.svg", metadata={"Date": None})
    plt.close(figure)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, nargs="?", help="gap data set of the flange tests")
    options = parser.parse_args()
    start_jax()
    plt.style.use(HERE / "style.mplstyle")
    draw_peaks(diagnose(read_table_1()))
    if options.folder:
        draw_flange_tests(diagnose(read_dataset(options.folder)))


if __name__ == "__main__":
    main()

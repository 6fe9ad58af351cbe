"""Draw docs/figures/table1_diagnosis.svg: what `diagnose` makes of the paper's Table 1, configs/table1.csv.

python docs/figures/measured.py
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from acf_jax.dataset import GapDataset, Measurement, Prior, RigPrior, Trial
from acf_jax.diagnosis import Diagnosis, diagnose
from acf_jax.evidence.posterior import UNKNOWN
from acf_jax.inference.parameters import Explanation, label
from acf_jax.start import start_jax

HERE = Path(__file__).parent
INK, GREY = "#1f2937", "#9ca3af"
BLUE = "#2563eb"
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


def draw_probabilities(panel: Axes, d: Diagnosis) -> None:
    """The most probable explanations as bars."""
    first = d.scored[:SHOWN]
    rows = np.arange(len(first))
    panel.barh(rows, [s.probability for s in first], height=0.55, color=BLUE)
    for row, s in enumerate(first):
        panel.text(s.probability + 0.015, row, f"{s.probability:.2g}", va="center", fontsize=9.5, color=INK)
    panel.set_yticks(rows, [name_of(s.explanation) for s in first])
    panel.invert_yaxis()
    panel.set(xlim=(0, 1.12), xticks=(0, 0.5, 1), xlabel="probability")
    panel.set_title("What explains the gap", loc="left", fontsize=11, color=INK)


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
    error.plot(o.v_e, refitted, "o-", color=BLUE, markersize=6, linewidth=1.2)
    error.text(
        0.98, 0.05, f"recalibrated on the other speeds: {d.gap['recalibrated'].peak_rms_percent:.2f} % (RMS)",
        transform=error.transAxes, ha="right", color=BLUE, fontsize=9.5,
    )  # fmt: skip
    error.text(0.98, 0.93, "± 2 standard deviations of 1 N noise", transform=error.transAxes, ha="right",
               color="#6b7280", fontsize=9.5)  # fmt: skip
    top = 1.25 * max(np.abs(refitted).max(), 2 * noise.max())
    error.set(ylim=(-top, top), xlabel="contact velocity, m/s", ylabel="error of the peak force, %")
    error.set_title("Each speed predicted without it", loc="left", fontsize=11, color=INK)
    draw_probabilities(probability, d)
    figure.savefig(HERE / "table1_diagnosis.svg", metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    start_jax()
    plt.style.use(HERE / "style.mplstyle")
    draw_peaks(diagnose(read_table_1()))

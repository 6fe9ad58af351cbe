"""Draw docs/figures/real_RIG.png: the measured traces of each set of a rig, and what the diagnosis made of them.

    python -m docs.figures.real SETS RESULTS

SETS is what `python -m benchmarks.measured build` wrote, RESULTS what `score` wrote. The traces are drawn as an image:
no recording is part of this repository.
"""

import argparse
import json
import textwrap
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from acf_jax.dataset import GapDataset, read_dataset

HERE = Path(__file__).parent
INK, GREY = "#1f2937", "#9ca3af"
COLOURS = {"right": "#15803d", "wrong": "#b91c1c"}
MODELS = ("nominal", "recalibrated", "corrected")
WIDTH = 5.2  # inches a set
COLUMNS = 3
LETTERS = 58  # of a line over a set


def draw_rig(rows: list[dict[str, Any]], sets: Path, out: Path) -> None:
    """One panel a set: traces on top, the error of the models on held-out conditions below."""
    columns = min(COLUMNS, len(rows))
    lines = -(-len(rows) // columns)
    figure, axes = plt.subplots(
        2 * lines,
        columns,
        figsize=(WIDTH * columns, 4.2 * lines),
        squeeze=False,
        gridspec_kw={"height_ratios": [3, 1] * lines},
    )
    for panel in axes.flat:
        panel.set_visible(False)
    for i, row in enumerate(rows):
        top, below = (axes[2 * (i // columns) + k, i % columns] for k in (0, 1))
        draw_set(top, row, read_dataset(sets / row["rig"] / row["set"]))
        draw_errors(below, row)
    figure.tight_layout()
    figure.savefig(out, dpi=80)
    plt.close(figure)


def draw_set(panel: Axes, row: dict[str, Any], dataset: GapDataset) -> None:
    """The traces, darker the faster, or the peaks against the speed."""
    panel.set_visible(True)
    traces = [t for t in dataset.trials if t.trace]
    fastest = max(t.contact_velocity for t in dataset.trials)
    end = min(2.5 * dataset.rig.impact_time, max((t.trace.time[-1] for t in traces if t.trace), default=0.0))
    for trial in traces:
        assert trial.trace is not None
        shown = (trial.trace.time > -0.1 * end) & (trial.trace.time < end)
        shade = 0.3 + 0.6 * trial.contact_velocity / fastest
        panel.plot(
            1e3 * trial.trace.time[shown], trial.trace.force[shown], color=str(1 - shade), linewidth=0.8
        )
    panel.set_xlabel("ms" if traces else "contact velocity in m/s")
    if not traces:
        panel.plot(
            *np.array([(t.contact_velocity, t.peak_force) for t in dataset.trials]).T, "o", color=INK, ms=3
        )
    panel.set_ylabel("N")
    said = " and ".join(row["first"]) or "nothing unmodelled"
    colour = COLOURS.get(row["outcome"], INK)
    lines = [row["set"], *textwrap.wrap(f"{row['verdict']}: {said}", LETTERS)]
    panel.set_title("\n".join(lines), loc="left", fontsize=9, color=colour)


def draw_errors(panel: Axes, row: dict[str, Any]) -> None:
    """RMS of the force on held-out conditions, N; of peaks, percent, where there are no traces."""
    gap = row["gap"]
    values = {m: gap[m]["force_rms_n"] for m in MODELS if gap.get(m) and gap[m]["force_rms_n"] is not None}
    if not values:
        return
    panel.set_visible(True)
    panel.barh(list(values), list(values.values()), color=GREY, height=0.6)
    if gap["noise_floor_rms_n"] is not None:
        panel.axvline(gap["noise_floor_rms_n"], color=INK, linewidth=1.2)
    panel.invert_yaxis()
    panel.tick_params(labelsize=8)
    panel.set_xlabel("held-out error in N RMS; line: noise and scatter", fontsize=8)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sets", type=Path)
    parser.add_argument("results", type=Path)
    given = parser.parse_args()
    plt.style.use(HERE / "style.mplstyle")
    rows = json.loads((given.results / "results.json").read_text("utf-8"))
    for rig in dict.fromkeys(row["rig"] for row in rows):
        draw_rig([row for row in rows if row["rig"] == rig], given.sets, HERE / f"real_{rig}.png")


if __name__ == "__main__":
    main()

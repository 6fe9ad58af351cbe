"""Draw docs/figures/corrected_frontier.svg: networks for a surrogate of a corrected model, error against speed.

python -m docs.figures.corrected_frontier

reads docs/figures/corrected_frontier.csv, which `python -m benchmarks.corrected_frontier --csv FILE` writes.
"""

import argparse
import csv
from pathlib import Path

import matplotlib.pyplot as plt

HERE = Path(__file__).parent
INK, QUIET = "#1f2937", "#6b7280"
COLOURS = {"tanh": "#d97706", "softsign": "#2563eb"}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--csv", type=Path, default=HERE / "corrected_frontier.csv")
    parser.add_argument("--out", type=Path, default=HERE / "corrected_frontier.svg")
    options = parser.parse_args()
    with options.csv.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))

    plt.style.use(HERE / "style.mplstyle")
    figure, panels = plt.subplots(1, 2, figsize=(10, 3.8), sharey=True, layout="constrained")
    most = max(int(row["steps"]) for row in rows)
    for axes, precision in zip(panels, ("float64", "float32"), strict=True):
        axes.axhline(0.1, color="#9ca3af", linewidth=1.2, linestyle=(0, (4, 2)))
        axes.axvline(20, color="#9ca3af", linewidth=1.2, linestyle=(0, (4, 2)))
        for row in rows:
            x, y, colour = float(row[precision]), 100 * float(row["error"]), COLOURS[row["activation"]]
            is_trained = int(row["steps"]) == most
            on_the_left = row["activation"] == "tanh" and is_trained
            axes.plot(x, y, "o", color=colour, markersize=6, fillstyle="full" if is_trained else "none")
            axes.annotate(
                f"{row['width']} × {row['depth']}" + ("" if is_trained else f", {int(row['steps']):,} steps"),
                (x, y),
                (-7, -6 if row["width"] == "16" and row["depth"] == "2" else 6) if on_the_left else (7, 0),
                textcoords="offset points",
                ha="right" if on_the_left else "left",
                va="center",
                fontsize=9,
                color=colour,
            )
        axes.set(xscale="log", xlabel="times as fast as the fastest simulation within 0.1 %")
        axes.set_xlim(5, 50)
        axes.set_xticks([5, 10, 20, 50], ["5", "10", "20", "50"])
        axes.minorticks_off()
        axes.set_title(precision, loc="left", fontsize=11, color=INK)
    panels[0].set(ylabel="largest error of the peak force, %", ylim=(0, 0.12))
    for i, (activation, colour) in enumerate(COLOURS.items()):
        panels[0].text(
            0.04, 0.14 - 0.08 * i, activation, transform=panels[0].transAxes, fontsize=9.5, color=colour
        )
    panels[1].text(
        0.04, 0.06, "dashed: what is asked for", transform=panels[1].transAxes, fontsize=9.5, color=QUIET
    )
    figure.savefig(options.out, metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    main()

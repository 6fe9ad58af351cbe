"""Draw docs/figures/blind_runs.svg: what the blind runs of one version after the other came to.

python docs/figures/blind_runs.py

Reads docs/figures/blind_runs.csv, a line for each run; those of at least a hundred data sets are drawn. Prints all of
them as the tables of docs/blind_history.md.
"""

import csv
from collections.abc import Callable
from operator import itemgetter
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from scipy.stats import binomtest

HERE = Path(__file__).parent
LARGE = 100  # data sets of a run that is drawn
MET, MISSED, ASKED = "#2563eb", "#d9480f", "#1f2937"
SHARES = {  # column: title, what is asked
    "clear_covered": ("clear effects in the credible set", 0.98),
    "clear_first": ("clear effects first or in one class", 0.97),
    "weak_first": ("weak effects first, over the ceiling", 0.95),
    "pairs_whole": ("pairs whole", 0.75),
    "pairs_in_part": ("pairs in part", 0.97),
    "false_alarms": ("false alarms", 0.05),
    "unknown_recalled": ("unknown causes recalled", 0.90),
    "unknown_component": ("their component", 0.80),
    "shrinkage_inside": ("shrinkage in its interval", 0.90),
}
BEYOND = ("calibration error beyond chance", 0.05)
Run = dict[str, str]


def share(run: Run, column: str) -> tuple[float, float, float] | None:
    """Share and its 95 % interval; of weak effects over the ceiling of any method."""
    if not run[column]:
        return None
    right, n = map(int, run[column].split("/"))
    ceiling = float(run["weak_ceiling"] or "nan") if column == "weak_first" else 1.0
    ends = binomtest(right, n).proportion_ci(0.95)
    return right / n / ceiling, ends.low / ceiling, ends.high / ceiling


def beyond_chance(run: Run) -> float | None:
    """Expected calibration error beyond what chance explains."""
    if not run["calibration_error"]:
        return None
    return max(float(run["calibration_error"]) - float(run["calibration_chance"]), 0.0)


def meets(run: Run) -> int:
    """How many of the ten targets a run meets."""
    found = {column: share(run, column) for column in SHARES}
    met = [
        value[0] <= asked if column == "false_alarms" else value[0] >= asked
        for column, (_, asked) in SHARES.items()
        if (value := found[column])
    ]
    beyond = beyond_chance(run)
    return sum(met) + (beyond is not None and beyond <= BEYOND[1])


def draw(axes: Axes, runs: list[Run], column: str) -> None:
    """One figure over the runs, the target dashed."""
    title, asked = SHARES[column]
    for x, run in enumerate(runs):
        if value := share(run, column):
            met = value[0] <= asked if column == "false_alarms" else value[0] >= asked
            axes.errorbar(
                x, value[0], [[value[0] - value[1]], [value[2] - value[0]]],
                color=MET if met else MISSED, marker="o", capsize=2,
            )  # fmt: skip
    finish(axes, runs, title, asked)


def draw_calibration(axes: Axes, runs: list[Run]) -> None:
    """Calibration error beyond chance over the runs."""
    for x, run in enumerate(runs):
        if (value := beyond_chance(run)) is not None:
            axes.plot(x, value, "o", color=MET if value <= BEYOND[1] else MISSED)
    finish(axes, runs, *BEYOND)


def finish(axes: Axes, runs: list[Run], title: str, asked: float) -> None:
    """Target, title and the seeds below."""
    axes.axhline(asked, color=ASKED, lw=1, ls="--")
    axes.set_title(title, fontsize=10)
    axes.set_xticks(range(len(runs)), [run["seed"] for run in runs], rotation=60)
    few = asked < 0.5
    axes.set_ylim((-0.004, 0.2) if few else (-0.02, 1.15) if "ceiling" in title else (0.3, 1.03))
    if few:
        axes.set_yticks(np.linspace(0, 0.2, 5))
    axes.yaxis.set_major_formatter("{x:.2f}" if "calibration" in title else lambda y, _: f"{100 * y:.0f} %")


def table(runs: list[Run]) -> str:
    """Runs as Markdown, a column each, the newest first."""

    def row(title: str, cell: Callable[[Run], str]) -> str:
        return f"| {' | '.join([title, *(cell(run) or '-' for run in reversed(runs))])} |"

    def calibration(run: Run) -> str:
        return f"{run['calibration_error']} ({run['calibration_chance']})" if run["calibration_error"] else ""

    lines = [
        row("seed", lambda run: run["seed"]),
        row("---", lambda run: "---"),
        row("data sets", lambda run: run["data_sets"]),
        row("in November 2026", lambda run: run["date"][-2:]),
        row("diagnosed by", lambda run: run["commit"]),
        *(row(title.split(",")[0], itemgetter(column)) for column, (title, _) in SHARES.items()),
        row("ceiling of weak effects first", itemgetter("weak_ceiling")),
        row("calibration error (by chance up to)", calibration),
    ]
    if int(runs[0]["data_sets"]) >= LARGE:
        lines.append(row("**targets met, of ten**", lambda run: f"**{meets(run)}**"))
    return "\n".join(lines) + "\n"


def main() -> None:
    """Draw the large runs, print all."""
    with (HERE / "blind_runs.csv").open(encoding="utf-8", newline="") as file:
        runs = list(csv.DictReader(file))
    large = [run for run in runs if int(run["data_sets"]) >= LARGE]
    plt.style.use(HERE / "style.mplstyle")
    figure, grid = plt.subplots(4, 3, figsize=(10, 10), layout="constrained")
    *panels, spare, last = np.ravel(grid)
    spare.set_axis_off()
    last.set_axis_off()
    for axes, column in zip(panels, SHARES, strict=False):
        draw(axes, large, column)
    draw_calibration(panels[-1], large)
    figure.supxlabel("seed of the run, one version of the diagnosis after the other", fontsize=10)
    figure.savefig(HERE / "blind_runs.svg")
    print(table(large))
    print(table([run for run in runs if run not in large]))


if __name__ == "__main__":
    main()

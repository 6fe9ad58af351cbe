"""Draw docs/figures/blind_runs.svg: what the blind runs of one version after the other came to.

python -m docs.figures.blind_runs

Reads docs/figures/blind_runs.csv, a line for each run; those of at least a hundred data sets are drawn. Prints all of
them as the tables of docs/blind_history.md.
"""

import csv
from collections.abc import Callable
from operator import itemgetter
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from validation.blind.summary import counted
from validation.blind.targets import targets

HERE = Path(__file__).parent
LARGE = 100  # data sets of a run that is drawn
MET, MISSED, ASKED = "#2563eb", "#d9480f", "#1f2937"
COLUMNS = {  # of the file, in the order of the targets: its place in a score, and a title
    "clear_covered": ("clear", "covered", "clear effects in the credible set"),
    "clear_first": ("clear", "first", "clear effects first or in one class"),
    "weak_first": ("weak", "first", "weak effects first, over the ceiling"),
    "pairs_whole": ("pair", "both_first", "pairs whole"),
    "pairs_in_part": ("pair", "one_first", "pairs in part"),
    "false_alarms": ("none", "false_alarms", "false alarms"),
    "unknown_recalled": ("unknown", "recalled", "unknown causes recalled"),
    "unknown_component": ("unknown", "component", "their component"),
    "calibration_error": ("calibration", "expected_error", "calibration error beyond chance"),
    "shrinkage_inside": ("shrinkage", "inside", "shrinkage in its interval"),
    "lifelike_wrong": ("lifelike", "identified_wrong", "lifelike rigs identified and wrong"),
}
Run = dict[str, str]


def score_of(run: Run) -> dict[str, Any]:
    """What of a run's score its line holds."""
    score: dict[str, Any] = {}
    for column, (kind, key, _) in COLUMNS.items():
        if kind != "calibration":
            right, n = map(int, (run.get(column) or "0/0").split("/"))
            score.setdefault(kind, {})[key] = counted(right, n)
    score["weak"]["ceiling"] = float(run["weak_ceiling"]) if run["weak_ceiling"] else None
    error, chance = run["calibration_error"], run["calibration_chance"]
    score["calibration"] = {"expected_error": float(error), "by_chance_95": float(chance)} if error else None
    return score


def is_known(runs: list[Run], column: str) -> bool:
    """Whether any of the runs had such data sets."""
    return any(run.get(column) for run in runs)


def shown(score: dict[str, Any], kind: str, key: str) -> tuple[float, float, float]:
    """A figure and its 95 % interval: of weak effects over the ceiling, of the calibration beyond chance."""
    found = score[kind]
    if kind == "calibration":
        beyond = max(found["expected_error"] - found["by_chance_95"], 0.0)
        return beyond, beyond, beyond
    whole = found["ceiling"] if kind == "weak" else 1.0
    low, high = found[key]["ci95"]
    return found[key]["share"] / whole, low / whole, high / whole


def draw(axes: Axes, runs: list[Run], number: int) -> None:
    """One target over the runs, what it asks for dashed."""
    kind, key, title = list(COLUMNS.values())[number]
    for x, run in enumerate(runs):
        score = score_of(run)
        target = targets(score)[number]
        if target.met is not None:
            y, low, high = shown(score, kind, key)
            axes.errorbar(
                x, y, [[y - low], [high - y]], color=MET if target.met else MISSED, marker="o", capsize=2
            )
    limit = targets(score_of(runs[0]))[number].limit
    axes.axhline(limit, color=ASKED, lw=1, ls="--")
    axes.set_title(title, fontsize=10)
    axes.set_xticks(range(len(runs)), [run["seed"] for run in runs], rotation=90)
    few = limit < 0.5
    axes.set_ylim((-0.004, 0.2) if few else (-0.02, 1.15) if kind == "weak" else (0.3, 1.03))
    if few:
        axes.set_yticks(np.linspace(0, 0.2, 5))
    axes.yaxis.set_major_formatter("{x:.2f}" if kind == "calibration" else lambda y, _: f"{100 * y:.0f} %")


def table(runs: list[Run]) -> str:
    """Runs as Markdown, a column each, the newest first."""

    def row(title: str, cell: Callable[[Run], str]) -> str:
        return f"| {' | '.join([title, *(cell(run) or '-' for run in reversed(runs))])} |"

    def calibration(run: Run) -> str:
        return f"{run['calibration_error']} ({run['calibration_chance']})" if run["calibration_error"] else ""

    def met(run: Run) -> str:
        return f"**{sum(target.met or False for target in targets(score_of(run)))}**"

    counts = {
        column: title.split(",")[0]
        for column, (kind, _, title) in COLUMNS.items()
        if kind != "calibration" and is_known(runs, column)
    }
    lines = [
        row("seed", itemgetter("seed")),
        row("---", lambda run: "---"),
        row("data sets", itemgetter("data_sets")),
        row("in November 2026", lambda run: run["date"][-2:]),
        row("diagnosed by", itemgetter("commit")),
        *(row(title, itemgetter(column)) for column, title in counts.items()),
        row("ceiling of weak effects first", itemgetter("weak_ceiling")),
        row("calibration error (by chance up to)", calibration),
    ]
    if int(runs[0]["data_sets"]) >= LARGE:
        lines.append(row("**targets met, of ten**", met))
    return "\n".join(lines) + "\n"


def main() -> None:
    """Draw the large runs, print all."""
    with (HERE / "blind_runs.csv").open(encoding="utf-8", newline="") as file:
        runs = list(csv.DictReader(file))
    large = [run for run in runs if int(run["data_sets"]) >= LARGE]
    plt.style.use(HERE / "style.mplstyle")
    figure, grid = plt.subplots(4, 3, figsize=(10, 10), layout="constrained")
    for number, axes in enumerate(np.ravel(grid)):
        if number < len(COLUMNS) and is_known(large, list(COLUMNS)[number]):
            draw(axes, large, number)
        else:
            axes.set_axis_off()
    figure.supxlabel("seed of the run, one version of the diagnosis after the other", fontsize=10)
    figure.savefig(HERE / "blind_runs.svg")
    print(table(large))
    print(table([run for run in runs if run not in large]))


if __name__ == "__main__":
    main()

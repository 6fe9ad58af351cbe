"""Draw docs/figures/blind.svg: what the reference run of blind.md came to.

python docs/figures/blind.py [SCORE]

SCORE is the score.json of a run; its figures are kept in docs/figures/blind.json and a line for each data set in
docs/figures/blind.csv, from which the picture is drawn without it.
"""

import argparse
import csv
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

HERE = Path(__file__).parent
KEPT, ROWS = HERE / "blind.json", HERE / "blind.csv"
FIRST, COVERED, CEILING = "#d9480f", "#2563eb", "#1f2937"
MARKED = {0.5: "o", 0.9: "s"}  # probabilities of the first explanation
COLUMNS = (
    "set",
    "world",
    "kind",
    "causes",
    "distance",
    "verdict",
    "first",
    "probability_first",
    "probability_truth",
)


def keep(score: Path) -> None:
    """Keep a score's figures, and a line for each data set."""
    content = json.loads(score.read_text("utf-8"))
    KEPT.write_text(json.dumps(content["score"], indent=1) + "\n", "utf-8")
    with ROWS.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow((*COLUMNS, "right"))
        for row in content["rows"]:
            cells = [row.get(c) for c in COLUMNS]
            shown = ["+".join(c) or "none" if isinstance(c, list) else c for c in cells]
            writer.writerow((*shown, row.get("first_in_class", False)))


def draw_accuracy(axes: Axes, score: dict[str, Any]) -> None:
    """Single effects: how often they are named, over their whitened distance."""
    bins = [b for b in score["by_distance"] if b["from"] >= 2]
    x = np.arange(len(bins))
    for key, color, name, shift in (
        ("covered", COVERED, "in the credible set", -0.06),
        ("first", FIRST, "first, or in one class with the first", 0.06),
    ):
        value = np.array([b[key]["share"] for b in bins])
        ends = np.array([b[key]["ci95"] for b in bins]).T
        axes.errorbar(x + shift, value, np.abs(ends - value), color=color, marker="o", capsize=2, label=name)
    weak = [i for i, b in enumerate(bins) if b["ceiling"] is not None]
    axes.plot(
        weak,
        [bins[i]["ceiling"] for i in weak],
        "_",
        ms=26,
        mew=2,
        color=CEILING,
        label="ceiling of the best decision",
    )
    labels = [f"{b['from']:g}–{b['to']:g}" if b["to"] else f"> {b['from']:g}" for b in bins]
    axes.set_xticks(x, [f"{name}\nn = {b['first']['n']}" for name, b in zip(labels, bins, strict=True)])
    axes.set(xlabel="whitened distance of the effect", ylabel="share of data sets", ylim=(0, 1.04))
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1.02), borderaxespad=0, frameon=False)


def draw_reliability(axes: Axes, score: dict[str, Any]) -> None:
    """Stated probability of the first explanation against how often it was right."""
    c = score["calibration"]
    axes.plot([0, 1], [0, 1], ":", color=CEILING, label="perfectly calibrated")
    axes.plot(
        [b["stated"] for b in c["bins"]], [b["observed"] for b in c["bins"]], "-o", color=FIRST,
        label=f"expected calibration error {c['expected_error']:.3f}\n(by chance up to {c['by_chance_95']:.3f})",
    )  # fmt: skip
    axes.set(xlabel="stated probability of the first explanation", ylabel="share that was right")
    axes.set(xlim=(0, 1.02), ylim=(0, 1.04))
    axes.legend(loc="upper left", frameon=False)


def draw_trade_off(axes: Axes, rows: Sequence[dict[str, str]]) -> None:
    """Answers right over answers wrong, where those below a probability are left out: from all to the surest."""
    for name, color, is_lifelike in (
        ("rigs without small effects", COVERED, False),
        ("lifelike rigs", FIRST, True),
    ):
        own = [r for r in rows if (r["kind"] == "lifelike") == is_lifelike]
        own.sort(key=lambda r: -float(r["probability_first"] or 0))
        right = np.cumsum([0, *(r["right"] == "True" for r in own)]) / len(own)
        wrong = np.cumsum([0, *(r["right"] != "True" for r in own)]) / len(own)
        axes.step(wrong, right, where="post", color=color, label=name)
        for least, marker in MARKED.items():
            k = sum(float(r["probability_first"] or 0) >= least for r in own)
            axes.plot(wrong[k], right[k], marker, color=color)
    for least, marker in MARKED.items():
        axes.plot([], [], marker, color=CEILING, label=f"those of at least {least:.0%}")
    axes.set(xlabel="share of data sets answered wrong", ylabel="share answered right", ylim=(0, 1.04))
    axes.legend(loc="lower right", frameon=False)


def draw_confusion(axes: Axes, score: dict[str, Any]) -> None:
    """What was answered first for each cause, in data sets."""
    counts = score["confusion"]
    last = ["a pair", "none", "unknown"]
    names = sorted({*counts, *(s for row in counts.values() for s in row)} - set(last)) + last
    table = np.array([[counts.get(c, {}).get(s, 0) for s in names] for c in names])
    axes.imshow(table / np.maximum(table.sum(1, keepdims=True), 1), cmap="Blues", vmin=0, vmax=1)
    for i, j in zip(*np.nonzero(table), strict=True):
        share = table[i, j] / table[i].sum()
        axes.text(
            j,
            i,
            str(table[i, j]),
            ha="center",
            va="center",
            fontsize=8,
            color="white" if share > 0.5 else "black",
        )
    shown = [n.replace("_", " ") for n in names]
    axes.set_xticks(range(len(names)), shown, rotation=50, ha="right")
    axes.set_yticks(range(len(names)), shown)
    axes.set(xlabel="answered first", ylabel="cause, weak ones included")


def main() -> None:
    """Keep the score that is named, and draw."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("score", nargs="?", type=Path)
    options = parser.parse_args()
    if options.score:
        keep(options.score)
    score = json.loads(KEPT.read_text("utf-8"))
    plt.style.use(HERE / "style.mplstyle")
    with ROWS.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    figure, axes = plt.subplot_mosaic(
        "ab;cd", figsize=(12, 10), height_ratios=(1, 1.35), layout="constrained"
    )
    draw_accuracy(axes["a"], score)
    draw_reliability(axes["b"], score)
    draw_trade_off(axes["c"], rows)
    draw_confusion(axes["d"], score)
    figure.savefig(HERE / "blind.svg")


if __name__ == "__main__":
    main()

"""`score.html`: the score of a blind run as one self-contained page."""

from collections.abc import Sequence
from typing import Any

from acf_jax import __version__
from acf_jax.report.markup import Html, details, element, table
from acf_jax.report.page import page, part
from acf_jax.report.plot import Variant, axis, plain, plot, series
from validation.blind.summary import Row
from validation.blind.table import cause_of, lifelike_figures, mark, named
from validation.blind.targets import shown, targets

VERDICTS = {True: ("met", "good"), False: ("missed", "bad"), None: ("too few cases", "muted")}


def score_page(name: str, rows: Sequence[Row], score: dict[str, Any], origin: str = "") -> str:
    """The page of a score; `origin`: how it came about."""
    parts = [
        part("targets", "Targets", "What was asked for, and what came out", _targets(score)),
        part("lifelike", "Lifelike rigs", "Large effects among small ones", _lifelike(score)),
        part("size", "Effect size", "Small effects and large ones", _by_distance(score)),
        part("confusion", "Confusion", "What was taken for what", _confusion(score)),
        part("calibration", "Calibration", "Do probabilities keep their word", _reliability(score)),
        part("shrinkage", "Shrinkage", "Claimed and real shrinkage", _shrinkage(rows)),
        part("misses", "Misses", "Every miss", _misses(rows)),
    ]
    foot = element(
        "p",
        f"acf-jax {__version__}. The rows behind this page are in score.json beside it. {origin}",
        class_="muted",
    )
    return page(f"Blind score: {name}", _head(name, score), [p for p in parts if p], foot)


def _head(name: str, score: dict[str, Any]) -> Html:
    all_targets = targets(score)
    met = sum(t.met is True for t in all_targets)
    asked = sum(t.met is not None for t in all_targets)
    right, first, alarms = score["first"], score["clear"]["first"], score["none"]["false_alarms"]
    parts = [f"{right['right']} of {right['n']} first answers are right"]
    if first["n"]:
        parts.append(f"{first['right']} of {first['n']} clear effects are named")
    if alarms["n"]:
        parts.append(f"{alarms['right']} of {alarms['n']} data sets without any cause raise an alarm")
    return Html(
        element("h1", f"Blind score of {name}")
        + element("p", f"{'; '.join(parts)}; {met} of {asked} targets are met.", class_="verdict")
        + element(
            "p",
            "Data sets whose cause was withheld. An answer is right where it is the cause, or cannot be told from it.",
            class_="muted",
        )
    )


def _targets(score: dict[str, Any]) -> Html:
    rows = [
        (t.name, t.asked, t.reached, element("span", VERDICTS[t.met][0], class_=f"tag {VERDICTS[t.met][1]}"))
        for t in targets(score)
    ]
    return table(
        "Targets of the blind run, with 95 % intervals of the shares",
        ["Figure", "Asked", "Reached", ""],
        rows,
    )


def _lifelike(score: dict[str, Any]) -> Html | None:
    if not score["lifelike"]["right"]["n"]:
        return None
    rows = [(name, shown(share)) for name, share in lifelike_figures(score["lifelike"])]
    return table("Lifelike rigs, with 95 % intervals of the shares", ["Figure", "Reached"], rows)


def _by_distance(score: dict[str, Any]) -> Html | None:
    bins = score["by_distance"]
    if not bins:
        return None
    x = [f"{b['from']:g} to {b['to']:g}" if b["to"] else f"above {b['from']:g}" for b in bins]

    def curve(key: str, label: str, color: str, dash: str) -> dict[str, Any]:
        values = [b[key]["share"] for b in bins]
        ends = [b[key]["ci95"] for b in bins]
        return {
            "type": "scatter", "mode": "lines+markers", "x": x, "y": series(values, 3), "name": label,
            "line": {"color": color, "dash": dash, "width": 2},
            "error_y": {
                "type": "data", "symmetric": False, "thickness": 1,
                "array": series([e[1] - v for e, v in zip(ends, values, strict=True)], 3),
                "arrayminus": series([v - e[0] for e, v in zip(ends, values, strict=True)], 3),
            },
            "text": [f"{b[key]['right']} of {b[key]['n']}" for b in bins],
            "hovertemplate": "%{x}: %{text}<extra></extra>",
        }  # fmt: skip

    data = [curve("first", "first, or in one class with the first", "--corrected", "solid")]
    data.append(curve("covered", "in the credible set", "--recalibrated", "dash"))
    ceiling = {
        "type": "scatter", "mode": "lines", "x": x, "name": "ceiling of the best method",
        "y": series([b["ceiling"] if b["ceiling"] is not None else float("nan") for b in bins], 3),
        "line": {"color": "--measured", "dash": "dot", "width": 2}, "hoverinfo": "skip",
    }  # fmt: skip
    layout = {
        "xaxis": axis("whitened distance", type="category"),
        "yaxis": axis("share of data sets", range=[0, 1.05]),
    }
    caption = (
        "Whitened distance: what no adjustment of the paper's model imitates, in standard deviations of the noise."
        " Below 6 an effect counts as weak; there the ceiling says how often the best method would name it."
    )
    return plot(
        "by-distance", "Accuracy over effect size", caption, [Variant("", [*data, ceiling])], layout, 380
    )


def _confusion(score: dict[str, Any]) -> Html | None:
    counts = score["confusion"]
    if not counts:
        return None
    causes = sorted(counts)
    said = sorted({s for row in counts.values() for s in row} | set(causes))
    share = [[counts[c].get(s, 0) / sum(counts[c].values()) for s in said] for c in causes]
    heat = {
        "type": "heatmap", "x": [plain(s) for s in said], "y": [plain(c) for c in causes],
        "z": [series(row, 3) for row in share], "zmin": 0, "zmax": 1,
        "colorscale": [[0, "--low"], [1, "--high"]], "showscale": False, "xgap": 1, "ygap": 1,
        "text": [[str(counts[c].get(s, "") or "") for s in said] for c in causes],
        "texttemplate": "%{text}", "hovertemplate": "%{y} answered as %{x}: %{text}<extra></extra>",
    }  # fmt: skip
    layout = {
        "xaxis": axis("answer", tickangle=-45),
        "yaxis": axis("cause", autorange="reversed"),
        "margin": {"b": 150, "l": 150},
    }
    caption = (
        "Rows are causes, columns what was answered first; weak effects included, lifelike rigs not."
        " Numbers are data sets."
    )
    return plot("confusion-map", "Confusion matrix", caption, [Variant("", [heat])], layout, 620)


def _reliability(score: dict[str, Any]) -> Html | None:
    c = score["calibration"]
    if not c:
        return None
    bins = c["bins"]
    data: list[dict[str, Any]] = [
        {"type": "scatter", "mode": "lines", "x": [0, 1], "y": [0, 1], "name": "perfectly calibrated",
         "line": {"color": "--measured", "dash": "dot", "width": 2}, "hoverinfo": "skip"},
        {"type": "scatter", "mode": "lines+markers", "name": "first explanations",
         "x": series([b["stated"] for b in bins], 3), "y": series([b["observed"] for b in bins], 3),
         "marker": {"size": 9}, "line": {"color": "--corrected", "width": 2},
         "text": [f"{b['n']} data sets" for b in bins],
         "hovertemplate": "stated %{x:.2f}, right %{y:.2f}, %{text}<extra></extra>"},
    ]  # fmt: skip
    layout = {
        "xaxis": axis("stated probability", range=[0, 1.02]),
        "yaxis": axis("share that was right", range=[0, 1.02]),
    }
    caption = (
        f"Expected calibration error {c['expected_error']:.3f}; a perfectly calibrated diagnosis would show"
        f" {c['by_chance_mean']:.3f} on average and more than {c['by_chance_95']:.3f} in one run of twenty."
    )
    return plot("reliability", "Reliability", caption, [Variant("", data)], layout, 420)


def _shrinkage(rows: Sequence[Row]) -> Html | None:
    claimed = [r for r in rows if r.get("shrinkage") and "ratio" in r and r["kind"] != "none"]
    if not claimed:
        return None
    claimed.sort(key=lambda r: 1 - r["ratio"])
    value = [max(-1.0, r["shrinkage"]["value"]) for r in claimed]
    ends = [[max(-1.0, end) for end in r["shrinkage"]["ci95"]] for r in claimed]
    x = list(range(1, len(claimed) + 1))
    label = [plain(f"{r['set']} {cause_of(r)}") for r in claimed]
    data = [
        {"type": "scatter", "mode": "markers", "x": x, "y": series(value, 3), "name": "claimed, with its 95 % interval",
         "marker": {"color": "--recalibrated", "size": 5},
         "error_y": {"type": "data", "symmetric": False, "thickness": 1, "width": 0,
                     "array": series([max(0.0, e[1] - v) for e, v in zip(ends, value, strict=True)], 3),
                     "arrayminus": series([max(0.0, v - e[0]) for e, v in zip(ends, value, strict=True)], 3)},
         "text": label, "hovertemplate": "%{text}: claimed %{y:.2f}<extra></extra>"},
        {"type": "scatter", "mode": "markers", "x": x, "y": series([max(-1.0, 1 - r["ratio"]) for r in claimed], 3),
         "name": "real, on held-out conditions", "marker": {"color": "--corrected", "symbol": "diamond", "size": 7},
         "text": label, "hovertemplate": "%{text}: real %{y:.2f}<extra></extra>"},
    ]  # fmt: skip
    layout = {
        "xaxis": axis("data sets, by real shrinkage"),
        "yaxis": axis("shrinkage of the force error", range=[-1.05, 1.05]),
    }
    caption = "Below -1 is drawn at -1. Real: against noise-free forces at conditions that no trial had."
    return plot("shrinkage-plot", "Shrinkage", caption, [Variant("", data)], layout, 420)


def _misses(rows: Sequence[Row]) -> Html:
    missed = [r for r in rows if mark(r).strip() in ("MISS", "error", "cred.")]
    if not missed:
        return element("p", "There is none.")
    cells = [
        (
            r["set"], cause_of(r), r["world"],
            f"{r['distance']:.1f}" if r["distance"] is not None else "",
            *([r["verdict"], r["error"], "", ""] if "error" in r else _said(r)),
        )
        for r in missed
    ]  # fmt: skip
    head = [
        "Data set",
        "Cause",
        "World",
        "Distance",
        "Verdict",
        "First answer",
        "its probability",
        "of the truth",
    ]
    return details(f"{len(missed)} data sets whose first answer was not right", table("Misses", head, cells))


def _said(row: Row) -> list[str]:
    return [
        row["verdict"],
        named(row["first"]),
        f"{row['probability_first']:.2f}",
        f"{row['probability_truth']:.2f}",
    ]

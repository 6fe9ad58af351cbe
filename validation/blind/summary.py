"""The score of a blind run: what came out, beside what was asked for."""

import itertools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.stats import beta

from validation.blind.calibration import calibrate

Row = dict[str, Any]
COMPONENTS = ("actuator", "contact", "robot", "sensor")
INSIDE_SIGMA = 2.0


def share(rows: Sequence[Row], right: str | Callable[[Row], bool]) -> dict[str, Any]:
    """How many rows are right, with a 95 % interval (Clopper-Pearson)."""
    test = right if callable(right) else lambda row: bool(row.get(right))
    return counted(sum(map(test, rows)), len(rows))


def counted(k: int, n: int) -> dict[str, Any]:
    """The share of `k` right ones in `n`, with its interval."""
    if not n:
        return {"n": 0, "right": 0, "share": None, "ci95": None}
    low = float(beta.ppf(0.025, k, n - k + 1)) if k else 0.0
    high = float(beta.ppf(0.975, k + 1, n - k)) if k < n else 1.0
    return {"n": n, "right": k, "share": k / n, "ci95": [low, high]}


def summarise(rows: Sequence[Row]) -> dict[str, Any]:
    """All figures of a score, from the rows of `score_one`; a data set that could not be used counts as wrong."""
    kind = {
        name: [r for r in rows if r["kind"] == name]
        for name in ("none", "single", "pair", "beyond", "withheld", "lifelike")
    }
    clear = [r for r in kind["single"] if r["clear"]]
    weak = [r for r in kind["single"] if not r["clear"]]
    hidden = [r for r in kind["beyond"] + kind["withheld"] if r["clear"]]
    answered = [r for r in rows if "error" not in r]
    result = {
        "data_sets": len(rows),
        "errors": [r["set"] for r in rows if "error" in r],
        "first": share(rows, "first_in_class"),
        "first_strict": share(rows, "first_right"),
        "none": {
            "no_gap": share(kind["none"], lambda r: r["verdict"] == "no_gap"),
            "false_alarms": _alarms(kind["none"]),
        },
        "clear": {
            "covered": share(clear, "covered"),
            "first": share(clear, "first_in_class"),
            "first_strict": share(clear, "first_right"),
            "component": share(clear, "component_right"),
        },
        "weak": {
            "covered": share(weak, "covered"),
            "first": share(weak, "first_in_class"),
            "first_strict": share(weak, "first_right"),
            "ceiling": _mean([r["ceiling"] for r in weak if r.get("ceiling") is not None]),
        },
        "pair": {
            "both_first": share(kind["pair"], "first_right"),
            "both_first_in_class": share(kind["pair"], "first_in_class"),
            "one_first": share(kind["pair"], "one_right"),
            "covered": share(kind["pair"], "covered"),
        },
        "unknown": {
            "recalled": share(hidden, "first_in_class"),
            "recalled_strict": share(hidden, "first_right"),
            "beyond": share([r for r in hidden if r["kind"] == "beyond"], "first_in_class"),
            "withheld": share([r for r in hidden if r["kind"] == "withheld"], "first_in_class"),
            "component": share(hidden, "component_right"),
        },
        "lifelike": _lifelike(kind["lifelike"]),
        "credible_set_size": _mean([len(r["credible"]) for r in answered]),
        "calibration": _calibration(answered),
        "shrinkage": _shrinkage([r for r in answered if r["kind"] != "none"]),
        "contributions": _contributions([r for r in answered if r["kind"] != "none"]),
        "predicted_peaks": _predicted(answered),
        "rig_within_2_sigma": _rig(
            [r for r in answered if r["first_right"] and r["kind"] in ("none", "single", "pair")]
        ),
        "seconds": _seconds(answered),
        "by_distance": _by_distance(kind["single"]),
        "confusion": _confusion([r for r in answered if r["kind"] != "lifelike"]),
        "components": _components(answered),
    }
    return result


def _lifelike(rows: Sequence[Row]) -> dict[str, Any]:
    """Right: all large effects are named and none that is not in the rig; of a foreign cause it is `unknown`."""
    foreign = [r for r in rows if r["truth"] == ["unknown"]]
    return {
        "right": share(rows, "first_right"),
        "right_in_class": share(rows, "first_in_class"),
        "named": share([r for r in rows if r not in foreign], "first_right"),
        "unknown": share(foreign, "first_right"),
        "identified_wrong": share(
            rows, lambda r: r["verdict"] == "identified" and not r.get("first_in_class")
        ),
        "shrinkage": _shrinkage([r for r in rows if "error" not in r]),
    }


def _alarms(rows: Sequence[Row]) -> dict[str, Any]:
    """A false alarm names a cause where there is none: its first explanation is not the paper's model."""
    return share(rows, lambda r: r.get("first") != [])


def _mean(values: Sequence[float]) -> float | None:
    return float(np.mean(values)) if values else None


def _calibration(rows: Sequence[Row]) -> dict[str, Any] | None:
    """Of the first explanation's probability, an unknown cause's computed neighbour counting as right."""
    if not rows:
        return None
    right = np.array([r["first_right"] or (r["truth"] == ["unknown"] and r["first_in_class"]) for r in rows])
    c = calibrate(np.array([r["probability_first"] for r in rows]), right)
    return {
        "expected_error": c.error,
        "by_chance_95": c.by_chance,
        "by_chance_mean": c.expected_by_chance,
        "bins": [
            {"stated": float(s), "observed": float(o), "n": int(n)}
            for s, o, n in zip(c.stated, c.observed, c.cases, strict=True)
        ],
    }


def _shrinkage(rows: Sequence[Row]) -> dict[str, Any] | None:
    """Real shrinkage on noise-free conditions that no trial had, against the claimed interval."""
    claimed = [r for r in rows if r.get("shrinkage") and "ratio" in r]
    if not claimed:
        return None
    ratio = np.array([r["ratio"] for r in claimed])
    return {
        **_claims(claimed, "shrinkage", lambda r: 1 - r["ratio"]),
        "median_ratio": float(np.median(ratio)),
        "worst_ratio": float(ratio.max()),
    }


def _contributions(rows: Sequence[Row]) -> dict[str, Any] | None:
    """What the laws leave of the gap against the claimed interval of the background.

    Forces are noise-free, on conditions that no trial had. Of what is not scatter laws leave the square of the ratio of
    both models' errors.
    """
    claimed = [r for r in rows if r.get("unexplained") and "ratio" in r]
    if not claimed:
        return None
    return _claims(
        claimed, "unexplained", lambda r: (1 - r["unexplained"]["scatter"]) * min(r["ratio"], 1.0) ** 2
    )


def _predicted(rows: Sequence[Row]) -> dict[str, Any]:
    """How many peaks at conditions that no trial had lie in the 95 % interval that the corrected model states.

    Those of one data set are not independent, so that the share is less certain than its interval says.
    """
    counts = [r["peaks_inside_corrected"] for r in rows if "peaks_inside_corrected" in r]
    return counted(*(sum(column) for column in zip(*counts, strict=True))) if counts else counted(0, 0)


def _claims(rows: Sequence[Row], key: str, real: Callable[[Row], float]) -> dict[str, Any]:
    """How many of the intervals claimed under a key hold what is real, and how wide they are in the median."""
    ends = np.array([r[key]["ci95"] for r in rows])
    return {
        "inside": share(rows, lambda r: bool(r[key]["ci95"][0] <= real(r) <= r[key]["ci95"][1])),
        "median_width": float(np.median(ends[:, 1] - ends[:, 0])),
    }


def _rig(rows: Sequence[Row]) -> dict[str, Any]:
    errors = [e for r in rows for e in r["rig_error"].values()]
    return share([{"e": e} for e in errors], lambda r: abs(r["e"]) < INSIDE_SIGMA)


def _seconds(rows: Sequence[Row]) -> dict[str, float] | None:
    values = [r["seconds"] for r in rows if r.get("seconds")]
    return {"median": float(np.median(values)), "most": float(max(values))} if values else None


def _by_distance(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Accuracy of single effects against their whitened distance."""
    edges = (0.0, 2.0, 3.0, 4.0, 6.0, 10.0, 20.0, 60.0, 200.0, np.inf)
    table = []
    for low, high in itertools.pairwise(edges):
        here = [r for r in rows if r["distance"] is not None and low <= r["distance"] < high]
        if here:
            ceilings = [r["ceiling"] for r in here if r.get("ceiling") is not None]
            table.append(
                {
                    "from": low,
                    "to": high if np.isfinite(high) else None,
                    "first": share(here, "first_in_class"),
                    "covered": share(here, "covered"),
                    "ceiling": _mean(ceilings) if len(ceilings) == len(here) else None,
                }
            )
    return table


def _confusion(rows: Sequence[Row]) -> dict[str, dict[str, int]]:
    """How often each cause was answered with what; pairs and unknown causes are summed up."""
    table: dict[str, dict[str, int]] = {}
    for r in rows:
        cause = {"single": "+".join(r["truth"]), "none": "none", "pair": "a pair"}.get(r["kind"], "unknown")
        said = "none" if not r["first"] else r["first"][0] if len(r["first"]) == 1 else "a pair"
        counts = table.setdefault(cause, {})
        counts[said] = counts.get(said, 0) + 1
    return table


def _components(rows: Sequence[Row]) -> dict[str, dict[str, Any]]:
    """Of causes at one component: how often it is the most probable one."""
    return {c: share([r for r in rows if r["components"] == [c]], "component_right") for c in COMPONENTS}

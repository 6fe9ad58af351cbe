"""Score the diagnosis on a folder of gap data sets that have answers beside them.

    python benchmarks/score_gap.py FOLDER [--out RESULTS] [--only PATTERN]

Each set is read as a user's would be; its answer is opened after its diagnosis is made. Prints one line a set,
then the figures: is the truth in the credible set, is it first (with and without the classes that the diagnosis
computed), the error on held-out conditions against the recalibrated model, and whether the claimed shrinkage holds.
Resumes where it was stopped; --out keeps one JSON file a set.
"""

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from acf_jax.cli._start import start_jax
from acf_jax.dataset import read_conditions, read_dataset
from acf_jax.effects import library
from acf_jax.errors import InputError
from acf_jax.files import write_text


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--out", type=Path, default=Path("artifacts/score_gap"))
    parser.add_argument("--only", default="*", help="pattern of the folders to score")
    arguments = parser.parse_args()
    start_jax()
    rows = []
    for folder in sorted(p for p in arguments.folder.glob(arguments.only) if (p / "answer.yaml").exists()):
        kept = arguments.out / f"{folder.name}.json"
        if not kept.exists():
            write_text(kept, json.dumps(score(folder), indent=1))
        rows.append(json.loads(kept.read_text()))
        print(line(rows[-1]), flush=True)
    print(summary(rows))


def score(folder: Path) -> dict[str, Any]:
    """Diagnose one set, then open its answer."""
    from acf_jax.diagnosis.diagnose import diagnose
    from acf_jax.diagnosis.document import document
    from acf_jax.diagnosis.model_file import gap_model

    begin = time.perf_counter()
    try:
        diagnosis = diagnose(read_dataset(folder))
    except InputError as error:
        return {"set": folder.name, "error": str(error)}
    content = document(diagnosis)
    seconds = time.perf_counter() - begin
    answer = yaml.safe_load((folder / "answer.yaml").read_text())
    truth = sorted(answer["effects"])
    if any(name not in library() for name in truth):
        truth = ["unknown"]
    first = content["explanations"][0]["effects"]
    twins = [pair["effects"] for pair in content["indistinguishable"]]
    probability = {tuple(e["effects"]): e["probability"] for e in content["explanations"]}
    credible = [sorted(e) for e in content["credible_set"]]
    return {
        "set": folder.name,
        "truth": truth,
        "components": answer.get("components", []),
        "distance": answer.get("whitened_distance"),
        "verdict": content["verdict"],
        "first": first,
        "probability_first": content["explanations"][0]["probability"],
        "probability_truth": probability.get(tuple(truth), 0.0),
        "covered": truth in credible,
        "credible": credible,
        "first_right": sorted(first) == truth,
        "first_in_class": sorted(first) == truth
        or any(set(truth) | set(first) == set(pair) for pair in twins),
        "one_right": bool(set(first) & set(truth)) or truth == first,
        "component": content["where"]["component"],
        "shrinkage": content["shrinkage"]["force"],
        "excluded": [e["trial"] for e in content["excluded_trials"]],
        "faulty": list(answer.get("faulty_trials") or {}),
        "seconds": seconds,
        **held_out(folder, gap_model(diagnosis)),
    }


def held_out(folder: Path, model: Any) -> dict[str, Any]:
    """Root mean square error of the sensed force on noise-free held-out conditions, recalibrated and corrected."""
    from acf_jax.diagnosis.predict import predict

    if not (folder / "held_out_conditions.csv").exists():
        return {}
    trials = read_conditions(folder / "held_out_conditions.csv")
    v_e = np.array([t.contact_velocity for t in trials])
    f_p = np.array([t.pretension for t in trials])
    result: dict[str, Any] = {}
    for which in ("nominal", "recalibrated", "corrected"):
        squares, count, peaks = 0.0, 0, []
        for trial, prediction in zip(trials, predict(model, v_e, f_p, which), strict=True):
            true = np.loadtxt(
                folder / "held_out_traces" / f"{trial.name}.csv", delimiter=",", skiprows=1, ndmin=2
            )
            force = np.interp(true[1:, 0], prediction.time, prediction.force, right=0.0)
            squares += float(((force - true[1:, 1]) ** 2).sum())
            count += len(force)
            peaks.append(prediction.peak_force / true[:, 1].max() - 1)
        result[f"rms_{which}"] = (squares / count) ** 0.5
        result[f"peak_{which}"] = float(np.sqrt(np.mean(np.square(peaks))))
    result["ratio"] = result["rms_corrected"] / max(result["rms_recalibrated"], 1e-12)
    return result


def line(row: dict[str, Any]) -> str:
    if "error" in row:
        return f"{row['set']}: {row['error']}"
    mark = (
        "ok  "
        if row["first_right"]
        else ("twin" if row["first_in_class"] else ("cred" if row["covered"] else "MISS"))
    )
    s = row["shrinkage"]
    claimed = f"{s['value']:.3f} [{s['ci95'][0]:.3f}, {s['ci95'][1]:.3f}]" if s else "-"
    real = f"{1 - row['ratio']:.3f}" if "ratio" in row else "-"
    distance = f"{row['distance']:.1f}" if row.get("distance") is not None else "-"
    return (
        f"{row['set']} {mark} {row['verdict']:17s} truth {'+'.join(row['truth']) or 'none'} (d {distance}), first"
        f" {'+'.join(row['first']) or 'none'} {row['probability_first']:.2f}, shrinkage {claimed} real {real},"
        f" {row['seconds']:.0f} s"
    )


def summary(rows: list[dict[str, Any]]) -> str:
    rows = [r for r in rows if "error" not in r]
    groups = {
        "one effect": [r for r in rows if len(r["truth"]) == 1 and r["truth"] != ["unknown"]],
        "pairs": [r for r in rows if len(r["truth"]) == 2],
        "none": [r for r in rows if not r["truth"]],
        "outside the library": [r for r in rows if r["truth"] == ["unknown"]],
    }
    text = []
    for name, group in groups.items():
        if not group:
            continue

        def share(key: str, group: list[dict[str, Any]] = group) -> str:
            return f"{sum(bool(r[key]) for r in group)}/{len(group)}"

        text.append(
            f"{name}: in the credible set {share('covered')}, first {share('first_right')}, first or in one class"
            f" {share('first_in_class')}, at least one right {share('one_right')},"
            f" no_gap {sum(r['verdict'] == 'no_gap' for r in group)}/{len(group)}"
        )
    gap = [r for r in rows if r["truth"] and "ratio" in r]
    if gap:
        ratios = np.array([r["ratio"] for r in gap])
        text.append(
            "held-out force error, corrected over recalibrated:"
            f" median {np.median(ratios):.3f}, worst {ratios.max():.3f}"
        )
        claimed = [r for r in gap if r["shrinkage"]]
        inside = [r["shrinkage"]["ci95"][0] <= 1 - r["ratio"] <= r["shrinkage"]["ci95"][1] for r in claimed]
        widths = [r["shrinkage"]["ci95"][1] - r["shrinkage"]["ci95"][0] for r in claimed]
        text.append(
            f"real shrinkage inside the claimed interval: {sum(inside)}/{len(inside)},"
            f" median width {np.median(widths):.3f}"
        )
    text.append(
        f"time: median {np.median([r['seconds'] for r in rows]):.0f} s, most {max(r['seconds'] for r in rows):.0f} s"
    )
    return "\n".join(text)


if __name__ == "__main__":
    main()

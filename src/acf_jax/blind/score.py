"""One data set: what was said of it against what was true, and how the corrected model does on unseen conditions."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from acf_jax.blind.plan import WEAK
from acf_jax.dataset import read_conditions
from acf_jax.diagnosis.model_file import GapModel, read_model
from acf_jax.diagnosis.predict import predict
from acf_jax.effects import library
from acf_jax.files import read_text

UNKNOWN = ["unknown"]
COMPARABLE = (  # the rig's own constants mean the same in every world
    "moving_mass_kg",
    "damping_n_s_per_m",
    "actuator_stiffness_n_per_m",
    "contact_stiffness_n_per_m",
)


def score_one(data: Path, result: Path, answer: dict[str, Any]) -> dict[str, Any]:
    """The row of one data set.

    Arguments:
        data: the data set. result: its diagnosis. answer: `effects`, and what else is known (`components`, `withheld`,
            `neighbours`, `whitened_distance`, `ceiling`, `rig`, `faulty_trials`).
    """
    content = json.loads(read_text(result / "diagnosis.json"))
    named = sorted(answer["effects"])
    outside = bool(answer.get("outside_library")) or any(name not in library() for name in named)
    withheld = answer.get("withheld") or ""
    truth = UNKNOWN if outside or withheld else named
    row = {
        "set": data.name,
        "kind": _kind(named, outside, withheld),
        "causes": named,
        "truth": truth,
        "components": answer.get("components")
        or sorted({library()[n].component for n in named if n in library()}),
        "distance": answer.get("whitened_distance"),
        "world": answer.get("world", ""),
        "ceiling": answer.get("ceiling"),
        "neighbours": answer.get("neighbours") or {},
        "faulty": list(answer.get("faulty_trials") or {}),
    }
    row["clear"] = row["distance"] is None or row["distance"] >= WEAK[1]
    if "error" in content:
        return {**row, "verdict": "error", "error": content["error"]}
    seconds = result / "seconds.txt"
    return {
        **row,
        **_explained(content, truth, row["neighbours"]),
        "component_right": max(content["where"]["component"], key=content["where"]["component"].get)
        in row["components"],
        "shrinkage": content["shrinkage"]["force"],
        "excluded": [e["trial"] for e in content["excluded_trials"]],
        "seconds": float(read_text(seconds)) if seconds.exists() else None,
        "rig_error": _rig_error(content, answer),
        **_held_out(data, read_model(result / "model.json")),
    }


def _kind(named: list[str], outside: bool, withheld: str) -> str:
    if withheld:
        return "withheld"
    if outside:
        return "beyond"
    return {0: "none", 1: "single"}.get(len(named), "pair")


def _explained(content: dict[str, Any], truth: list[str], neighbours: dict[str, float]) -> dict[str, Any]:
    """Which explanations were given, and whether the truth is among them.

    One class with the truth: the diagnosis computed that these trials cannot separate the two, or, of an unknown cause,
    the harness did so before the diagnosis ran.
    """
    ranked = [(sorted(e["effects"]), float(e["probability"])) for e in content["explanations"]]
    first, probability = ranked[0]
    credible = [sorted(e) for e in content["credible_set"]]
    twins = [sorted(pair["effects"]) for pair in content["indistinguishable"]]

    def one_class(said: list[str]) -> bool:
        if truth == UNKNOWN:
            return len(said) == 1 and said[0] in neighbours
        return sorted({*truth, *said}) in twins

    return {
        "verdict": content["verdict"],
        "first": first,
        "probability_first": probability,
        "probability_truth": next((p for e, p in ranked if e == truth), 0.0),
        "credible": credible,
        "first_right": first == truth,
        "first_in_class": first == truth or one_class(first),
        "covered": truth in credible,
        "covered_in_class": truth in credible or any(map(one_class, credible)),
        "one_right": first == truth or bool(set(first) & set(truth)),
    }


def _rig_error(content: dict[str, Any], answer: dict[str, Any]) -> dict[str, float]:
    """Fitted less true constants of the rig in stated standard deviations."""
    errors = {}
    for name in COMPARABLE:
        fitted = content["parameters"].get(name)
        if fitted and fitted["std"] and name in (answer.get("rig") or {}):
            errors[name] = (fitted["value"] - answer["rig"][name]) / fitted["std"]
    return errors


def _held_out(data: Path, model: GapModel) -> dict[str, Any]:
    """Error of the sensed force and its peak on noise-free conditions that no trial had; empty where there are none."""
    if not (data / "held_out_conditions.csv").exists():
        return {}
    trials = read_conditions(data / "held_out_conditions.csv")
    v_e = np.array([t.contact_velocity for t in trials])
    f_p = np.array([t.pretension for t in trials])
    truths = [
        np.loadtxt(data / "held_out_traces" / f"{t.name}.csv", delimiter=",", skiprows=1, ndmin=2)
        for t in trials
    ]
    result: dict[str, Any] = {}
    for which in ("recalibrated", "corrected"):
        squares, count, peaks = 0.0, 0, []
        for true, prediction in zip(truths, predict(model, v_e, f_p, which), strict=True):
            force = np.interp(true[1:, 0], prediction.time, prediction.force, right=0.0)
            squares += float(((force - true[1:, 1]) ** 2).sum())
            count += len(force)
            peaks.append(prediction.peak_force / true[:, 1].max() - 1)
        result[f"rms_{which}"] = (squares / count) ** 0.5
        result[f"peak_{which}"] = float(np.sqrt(np.mean(np.square(peaks))))
    result["ratio"] = result["rms_corrected"] / max(result["rms_recalibrated"], 1e-12)
    return result

"""One data set: what was said of it against what was true, and how the corrected model does at other conditions."""

from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

from acf_jax.dataset import read_conditions, read_dataset
from acf_jax.dataset.columns import read_columns
from acf_jax.diagnosis.contributions import BACKGROUND, SCATTER
from acf_jax.effects import library
from acf_jax.errors import InputError
from acf_jax.gap_model import GapModel, read_model
from acf_jax.predict import predict
from validation.blind.answer import Answer, Failed, Said, read_seconds
from validation.blind.plan import WEAK

UNKNOWN = ["unknown"]
TWO_SIDED_95 = 1.96  # standard deviations
COMPARABLE = (  # the rig's own constants mean the same in every world
    "moving_mass_kg",
    "damping_n_s_per_m",
    "actuator_stiffness_n_per_m",
    "contact_stiffness_n_per_m",
)


def score_one(data: Path, result: Path, said: Said | Failed, answer: Answer) -> dict[str, Any]:
    """The row of one data set.

    **Arguments:** `data`: the data set. `result`: the folder of its diagnosis. `said`: what is scored of it. `answer`:
    `effects`, and what else is known.
    """
    row = asked(data.name, answer)
    if isinstance(said, Failed):
        return {**row, "verdict": "error", "error": said.error}
    claim = said.shrinkage.force
    return {
        **row,
        **explained(said, row["truth"], answer.neighbours, answer.background),
        "component_right": max(said.where.component, key=said.where.component.__getitem__)
        in row["components"],
        "shrinkage": None if claim is None else {"value": claim.value, "ci95": list(claim.ci95)},
        "unexplained": _unexplained(said),
        "excluded": [e.trial for e in said.excluded_trials],
        "seconds": read_seconds(result),
        "rig_error": _rig_error(said, answer),
        **_held_out(data, read_model(result / "model.json")),
    }


def asked(name: str, answer: Answer) -> dict[str, Any]:
    """What was true of the data set `name`: the part of its row that no diagnosis changes."""
    named = sorted(answer.effects)
    outside = answer.outside_library or any(name not in library() for name in named)
    row: dict[str, Any] = {
        "set": name,
        "kind": _kind(answer, named, outside),
        "causes": named,
        "background": sorted(answer.background),
        "truth": UNKNOWN if outside or answer.withheld else named,
        "components": list(answer.components)
        or sorted({library()[n].component for n in named if n in library()}),
        "distance": answer.whitened_distance,
        "world": answer.world,
        "ceiling": answer.ceiling,
        "neighbours": answer.neighbours,
        "faulty": list(answer.faulty_trials),
    }
    row["clear"] = row["distance"] is None or row["distance"] >= WEAK[1]
    return row


def _kind(answer: Answer, named: list[str], outside: bool) -> str:
    if answer.background:
        return "lifelike"
    if answer.withheld:
        return "withheld"
    if outside:
        return "beyond"
    return {0: "none", 1: "single"}.get(len(named), "pair")


def explained(
    said: Said, truth: list[str], neighbours: dict[str, float], background: Collection[str] = ()
) -> dict[str, Any]:
    """Which explanations were given, and whether the truth is among them.

    Of a rig with a background of small effects any explanation is right that names all large ones, and none that is not
    in the rig.

    One class with the truth: the diagnosis computed that these trials cannot separate the two, or, of an unknown cause,
    the harness did so before the diagnosis ran.
    """
    ranked = [(sorted(e.effects), e.probability) for e in said.explanations]
    first, probability = ranked[0]
    credible = [sorted(e) for e in said.credible_set]
    twins = [sorted(pair.effects) for pair in said.indistinguishable]

    def is_right(named: list[str]) -> bool:
        return named == truth if truth == UNKNOWN else {*truth} <= {*named} <= {*truth, *background}

    def one_class(named: list[str]) -> bool:
        if truth == UNKNOWN:
            return len(named) == 1 and named[0] in neighbours
        return len(named) == len(truth) and sorted({*truth, *named}) in twins

    return {
        "verdict": said.verdict,
        "first": first,
        "probability_first": probability,
        "probability_truth": sum(p for e, p in ranked if is_right(e)),
        "credible": credible,
        "first_right": is_right(first),
        "first_in_class": is_right(first) or one_class(first),
        "covered": any(map(is_right, credible)),
        "covered_in_class": any(is_right(e) or one_class(e) for e in credible),
        "one_right": is_right(first) or bool(set(first) & set(truth)),
    }


def _unexplained(said: Said) -> dict[str, Any] | None:
    """The share of the gap that is claimed to be no law's, and that of scatter; None where no law is named."""
    parts = {c.effect: c.force_share for c in said.contributions or ()}
    if not parts.keys() - {BACKGROUND, SCATTER}:
        return None
    return {"ci95": list(parts[BACKGROUND].ci95), "scatter": parts[SCATTER].value}


def _rig_error(said: Said, answer: Answer) -> dict[str, float]:
    """Fitted less true constants of the rig in stated standard deviations."""
    errors = {}
    for name in COMPARABLE:
        fitted = said.parameters.get(name)
        if fitted and fitted.std and fitted.value is not None and name in answer.rig:
            errors[name] = (fitted.value - answer.rig[name]) / fitted.std
    return errors


def _held_out(data: Path, model: GapModel) -> dict[str, Any]:
    """Error of the sensed force and its peak on noise-free conditions that no trial had; empty where there are none."""
    if not (data / "held_out_conditions.csv").exists():
        return {}
    tried = read_dataset(data).conditions
    trials = [t for t in read_conditions(data / "held_out_conditions.csv") if t.condition not in tried]
    if not trials:
        return {}
    v_e = np.array([t.contact_velocity for t in trials])
    f_p = np.array([t.pretension for t in trials])
    truths = [_true_force(data / "held_out_traces" / f"{t.name}.csv") for t in trials]
    result: dict[str, Any] = {}
    for which in ("recalibrated", "corrected"):
        squares, count, peaks, inside = 0.0, 0, [], []
        for true, prediction in zip(truths, predict(model, v_e, f_p, which), strict=True):
            force = force_at(true[1:, 0], prediction.time, prediction.force)
            squares += float(((force - true[1:, 1]) ** 2).sum())
            count += len(force)
            peak = true[:, 1].max()
            peaks.append(prediction.peak_force / peak - 1)
            inside.append(abs(prediction.peak_force - peak) <= TWO_SIDED_95 * prediction.peak_force_std)
        result[f"rms_{which}"] = (squares / count) ** 0.5
        result[f"peak_{which}"] = float(np.sqrt(np.mean(np.square(peaks))))
        result[f"peaks_inside_{which}"] = [sum(map(bool, inside)), len(inside)]
    result["ratio"] = result["rms_corrected"] / max(result["rms_recalibrated"], 1e-12)
    return result


def force_at(times: np.ndarray, predicted_at: np.ndarray, force: np.ndarray) -> np.ndarray:
    """A predicted force, N, at other times, s: zero after its end, by more than a rounding of the last instant."""
    return np.interp(times * (1 - 1e-9), predicted_at, force, right=0.0)


def _true_force(path: Path) -> np.ndarray:
    """Time, s, and force, N, of a noise-free trace, shape (samples, 2)."""
    table, (_, values) = read_columns(path, ("time_s", "force_n"))
    if not table.faults:
        if len(values) > 1 and (np.diff(values[:, 0]) > 0).all() and values[:, 1].max() > 0:
            return values
        table.fault("", "must hold an impact, its time increasing; draw the data set again")
    raise InputError(table.shown_faults())

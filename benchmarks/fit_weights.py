"""Fit the weights of the diagnosis's score on blind runs, and say how well calibrated it then is.

    python benchmarks/fit_weights.py RUN [RUN ...]

RUN is a folder of `python -m acf_jax blind --out RUN`, scored. The weights maximise the log probability of the truth,
under a prior that is as wide as a factor of e about the present ones; the runs of a reference score are not for this.
Prints the weights for src/acf_jax/diagnosis/score.py.
"""

import argparse
import json
from collections.abc import Sequence
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize

from acf_jax.blind.answer import Answer
from acf_jax.blind.calibration import calibrate
from acf_jax.blind.seal import open_answers
from acf_jax.diagnosis.score import UNKNOWN, WEIGHTS, Evidence, Weights, is_port, log_scores
from acf_jax.effects import library

LEAST = -12.0  # log probability of a truth below which a case costs no more: it is lost either way


class Case(NamedTuple):
    """What a case's fits left, and what was true."""

    evidence: Sequence[Evidence]
    samples: int
    right: set[tuple[str, ...]]  # explanations that count as the truth
    strict: tuple[str, ...]


def read_run(run: Path) -> list[Case]:
    """The cases of a blind run."""
    names = sorted(p.parent.name for p in (run / "results").glob("*/diagnosis.json"))
    answers = open_answers(run / "sets", run / "results", names)
    cases = []
    for name in names:
        content = json.loads((run / "results" / name / "diagnosis.json").read_text())
        if "evidence" in content:
            cases.append(_case(content, answers[name]))
    return cases


def _case(content: dict[str, Any], answer: Answer) -> Case:
    found = [
        Evidence(tuple(f["effects"]), f["chi_square"], tuple(f["rig_strain"]))
        for f in content["evidence"]["fits"]
    ]
    truth = tuple(sorted(answer.effects))
    if answer.withheld or any(name not in library() for name in truth):
        return Case(
            found, content["evidence"]["samples"], {UNKNOWN, *((n,) for n in answer.neighbours)}, UNKNOWN
        )
    return Case(found, content["evidence"]["samples"], {truth}, truth)


def explained(case: Case, weights: Weights) -> dict[tuple[str, ...], float]:
    """Probability of each explanation, unknown causes together."""
    score = log_scores(case.evidence, case.samples, weights)
    p = np.exp(score - score.max())
    total: dict[tuple[str, ...], float] = {}
    for name, value in zip([*(e.explanation for e in case.evidence), UNKNOWN], p / p.sum(), strict=True):
        key = UNKNOWN if is_port(name) else name
        total[key] = total.get(key, 0.0) + float(value)
    return total


def loss(log_weights: np.ndarray, cases: Sequence[Case]) -> float:
    """Minus the log probability of all truths, and the prior of the weights."""
    weights = Weights(*np.exp(log_weights))
    total = 0.0
    for case in cases:
        p = sum(value for name, value in explained(case, weights).items() if name in case.right)
        total -= max(np.log(max(p, 1e-300)), LEAST)
    return total + 0.5 * float(((log_weights - np.log(astuple(WEIGHTS))) ** 2).sum())


def report(name: str, cases: Sequence[Case], weights: Weights) -> str:
    """Accuracy and calibration with some weights."""
    ranked = [max(explained(c, weights).items(), key=lambda item: item[1]) for c in cases]
    right = np.array([first in c.right for (first, _), c in zip(ranked, cases, strict=True)])
    c = calibrate(np.array([p for _, p in ranked]), right)
    return (
        f"{name}: {right.sum()} of {len(cases)} first, said with {c.stated @ c.cases / len(cases):.3f} on average,"
        f" calibration error {c.error:.3f} (chance {c.by_chance:.3f})"
    )


def main() -> None:
    """Read the runs, fit, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("runs", nargs="+", type=Path)
    cases = [case for run in parser.parse_args().runs for case in read_run(run)]
    print(report("present weights", cases, WEIGHTS))
    start = np.log(astuple(WEIGHTS))
    best = minimize(
        loss, start, (cases,), "Nelder-Mead", options={"maxiter": 1500, "xatol": 1e-2, "fatol": 1e-2}
    )
    weights = Weights(*np.exp(best.x))
    print(report("fitted weights", cases, weights))
    for field, value in zip(fields(Weights), astuple(weights), strict=True):
        print(f"    {field.name} = {value:.3g}")


if __name__ == "__main__":
    main()

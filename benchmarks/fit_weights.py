"""Fit the weights of the diagnosis's score on blind runs, and say how well calibrated it then is.

    python -m benchmarks.fit_weights RUN [RUN ...]
    python -m benchmarks.fit_weights RUN --try free_curve=12 --try free_curve=16,nameless=18

RUN is a folder of `python -m acf_jax blind --out RUN`, scored, or a file of benchmarks/kept/. The weights
maximise the log probability of the truth, under a prior that is as wide as a factor of e about the present ones; a
reference run is for this only once the next one judges. Prints the weights for
src/acf_jax/evidence/scores.py; with `--try` only how the runs come out with these weights.
"""

import argparse
from collections import Counter
from collections.abc import Sequence
from dataclasses import astuple, fields, replace
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from acf_jax.evidence.posterior import UNKNOWN, components, probabilities
from acf_jax.evidence.scores import WEIGHTS, Weights, log_scores
from acf_jax.inference.parameters import is_free_curve
from benchmarks.evidence import Case, read_cases
from validation.blind.calibration import calibrate

LEAST = -12.0  # log probability of a truth below which a case costs no more: it is lost either way


def explained(case: Case, weights: Weights) -> dict[tuple[str, ...], float]:
    """Probability of each explanation, unknown causes together."""
    score = log_scores(case.evidence, case.samples, weights, case.noise_doubt)
    p = np.exp(score - score.max())
    total: dict[tuple[str, ...], float] = {}
    for name, value in zip([*(e.explanation for e in case.evidence), UNKNOWN], p / p.sum(), strict=True):
        key = UNKNOWN if is_free_curve(name) else name
        total[key] = total.get(key, 0.0) + float(value)
    return total


def component(case: Case, weights: Weights) -> str:
    """Where the cause most probably acts."""
    p = probabilities(case.evidence, case.samples, weights, case.noise_doubt)
    where = components(case.evidence, p)
    return max(where, key=where.__getitem__)


def log_probability(case: Case, weights: Weights) -> float:
    """Of the truth."""
    p = sum(value for name, value in explained(case, weights).items() if name in case.right)
    return float(max(np.log(max(p, 1e-300)), LEAST))


def loss(log_weights: np.ndarray, cases: Sequence[Case]) -> float:
    """Minus the log probability of all truths, and the prior of the weights."""
    weights = Weights(*np.exp(log_weights))
    total = sum(log_probability(case, weights) for case in cases)
    return 0.5 * float(((log_weights - np.log(astuple(WEIGHTS))) ** 2).sum()) - total


def report(name: str, cases: Sequence[Case], weights: Weights) -> str:
    """Accuracy, log loss and calibration with some weights; the whole truth first, whatever its class."""
    ranked = [max(explained(c, weights).items(), key=lambda item: item[1]) for c in cases]
    right = np.array([first in c.right for (first, _), c in zip(ranked, cases, strict=True)])
    c = calibrate(np.array([p for _, p in ranked]), right)
    every, first = (
        Counter(c.kind for c in cases),
        Counter(c.kind for c, ok in zip(cases, right, strict=True) if ok),
    )
    by_kind = ", ".join(f"{kind} {first[kind]}/{n}" for kind, n in sorted(every.items()))
    located = sum(component(c, weights) in c.components for c in cases if c.kind == "unknown")
    lost = -np.mean([log_probability(case, weights) for case in cases])
    stated = c.stated @ c.cases / len(cases)
    return (
        f"{name}: {by_kind} (component {located}); log loss {lost:.3f}; said with {stated:.3f} on average,"
        f" right {right.mean():.3f}, calibration error {c.error:.3f} (chance {c.by_chance:.3f})"
    )


def changed(text: str) -> Weights:
    """The present weights with some changed, as in `free_curve=12,nameless=14`."""
    try:
        values = {name: float(value) for name, value in (part.split("=", 1) for part in text.split(","))}
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not of the form free_curve=12,nameless=14") from None
    if unknown := set(values) - {field.name for field in fields(Weights)}:
        raise argparse.ArgumentTypeError(f"no weight {', '.join(sorted(unknown))}")
    return replace(WEIGHTS, **values)


def _difference(weights: Weights) -> str:
    present = zip(fields(Weights), astuple(WEIGHTS), astuple(weights), strict=True)
    return ", ".join(f"{field.name} {new:g}" for field, old, new in present if new != old)


def main() -> None:
    """Read the runs, fit, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("runs", nargs="+", type=Path)
    parser.add_argument("--try", dest="tried", action="append", type=changed, metavar="NAME=VALUE,...")
    chosen = parser.parse_args()
    cases = [case for run in chosen.runs for case in read_cases(run)]
    print(report("present weights", cases, WEIGHTS))
    for weights in chosen.tried or ():
        print(report(_difference(weights), cases, weights))
    if chosen.tried:
        return
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

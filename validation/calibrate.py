"""Learn on blind runs how much conditions differ that no trial had, and say how probable the posterior made the truth.

    python -m acf_jax blind --out RUN --seed 7201 --cases 120
    python -m validation.calibrate RUN [RUN ...]

finds the degrees of freedom elsewhere with which 95 % of the stated shrinkages hold, and writes
src/acf_jax/evidence/calibration.json. The run has to be diagnosed with the number that stands there. With `--no-write`
it only says what comes out. Where log evidence is surer than it is right, the truth is more probable once that is
divided by more than one (Gruenwald and van Ommen, 'Inconsistency of Bayesian inference for misspecified linear models,
and a proposal for repairing it', Bayesian Analysis 12, 2017).
"""

import argparse
import json
import subprocess
from collections import Counter
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import chi2

from acf_jax.errors import InputError
from acf_jax.evidence.learnt import CALIBRATION, ELSEWHERE
from acf_jax.evidence.marginal import Marginal, read_evidence
from acf_jax.evidence.posterior import UNKNOWN, posterior
from acf_jax.files import read_json_mapping, write_text
from acf_jax.inference.parameters import Explanation

LEAST = 1e-3  # probability of the truth below which a set counts no more: it may never have been fitted
TEMPERATURES = (0.7, 1.0, 1.5, 2.0, 3.0)
HOLD = 0.95  # share of the stated shrinkages that shall hold
DEGREES = np.geomspace(30.0, 0.5, 83)  # of freedom that are tried: the tails of fewer ones are wider
FILE = Path(__file__).parents[1] / "src" / "acf_jax" / "evidence" / CALIBRATION


class Case(NamedTuple):
    """A data set: its evidence, and the explanations that count as the truth."""

    name: str
    kind: str  # "none", "single", "pair", "unknown" or "lifelike"
    evidence: Sequence[Marginal]
    right: frozenset[Explanation]
    stated: tuple[float, float, float] | None  # shrinkage and its interval, in log of what is left
    left: float  # log of what is left in truth


def read_cases(run: Path) -> list[Case]:
    """The cases of a blind run that is scored."""
    again = f"finish `python -m acf_jax blind --out {run}` first"
    rows = read_json_mapping(run / "results" / "score.json", again)["rows"]
    told = [row for row in rows if "error" not in row]
    return [_case(row, read_evidence(run / "results" / row["set"] / "diagnosis.json")) for row in told]


def _case(row: dict[str, Any], evidence: Sequence[Marginal]) -> Case:
    truth = tuple(row["truth"])
    # of a lifelike rig small effects may be named as well
    small = [] if truth == UNKNOWN else row["background"]
    right = {tuple(sorted(truth + some)) for n in range(len(small) + 1) for some in combinations(small, n)}
    if truth == UNKNOWN:
        right |= {(name,) for name in row["neighbours"]}
    kind = "unknown" if truth == UNKNOWN and row["kind"] != "lifelike" else row["kind"]
    claim, remains = row["shrinkage"], row.get("ratio")
    stated = claim and tuple(_log_left(x) for x in (claim["value"], *claim["ci95"]))
    return Case(
        row["set"], kind, evidence, frozenset(right), stated if remains else None, np.log(remains or 1.0)
    )


def _log_left(shrinkage: float) -> float:
    return float(np.log(max(1 - shrinkage, 1e-6)))


def freedom_elsewhere(cases: Sequence[Case]) -> float:
    """The most degrees of freedom elsewhere with which the stated shrinkages of these cases would have held."""
    stated = [(case.left, *case.stated) for case in cases if case.stated]
    if not stated:
        raise InputError("no set states a shrinkage: there is nothing to learn from; name more runs")
    left, value, high, low = np.array(stated).T
    ends = np.where(left < value, low, high)
    before = np.where(left < value, *_tails(ELSEWHERE))
    own = (ends - value) ** 2 - before**2  # what else is uncertain, in quadrature
    for freedom in DEGREES:
        tail = np.where(left < value, *_tails(freedom))
        if ((left - value) ** 2 <= own + tail**2).mean() >= HOLD:
            return float(freedom)
    return float(DEGREES[-1])


def _tails(freedom: float) -> tuple[float, float]:
    """Log of the ends of 95 % of a root mean square over its median, the lower and the upper one."""
    low, median, high = chi2.ppf([0.025, 0.5, 0.975], freedom)
    return 0.5 * np.log(low / median), 0.5 * np.log(high / median)


def log_loss(case: Case, temperature: float = 1.0) -> float:
    """Minus the log probability of the truth, log evidence divided by a temperature."""
    evidence = [
        m._replace(
            objective=m.objective / temperature,
            log_occam=m.log_occam / temperature,
            of_conditions=tuple(x / temperature for x in m.of_conditions),
        )
        for m in case.evidence
    ]
    p = sum(s.probability for s in posterior(evidence).scored if s.explanation in case.right)
    return -float(np.log(max(p, LEAST)))


def report(cases: Sequence[Case]) -> str:
    """Accuracy, surely wrong answers and log loss of each kind."""
    total, right, wrong = Counter[str](), Counter[str](), Counter[str]()
    lost: dict[str, list[float]] = {}
    for case in cases:
        scored = posterior(case.evidence).scored
        is_right = scored[0].explanation in case.right
        total[case.kind] += 1
        right[case.kind] += is_right
        wrong[case.kind] += not is_right and scored[0].probability > 0.9
        lost.setdefault(case.kind, []).append(log_loss(case))
    lines = [
        f"{kind:9} right {right[kind]} of {n}, wrong above 90 %: {wrong[kind]}, log loss {np.mean(lost[kind]):.3f}"
        for kind, n in sorted(total.items())
    ]
    by = [f"{t:g}: {np.mean([log_loss(c, t) for c in cases]):.3f}" for t in TEMPERATURES]
    return "\n".join([*lines, f"log loss with log evidence divided by {', '.join(by)}"])


def main() -> None:
    """Read the runs, learn, print, write."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("runs", nargs="+", type=Path)
    parser.add_argument("--no-write", action="store_true")
    chosen = parser.parse_args()
    try:
        cases = [case for run in chosen.runs for case in read_cases(run)]
        started = [read_json_mapping(run / "sets" / "run.json", "name a run's folder") for run in chosen.runs]
        elsewhere = freedom_elsewhere(cases)
    except InputError as error:
        raise SystemExit(f"error: {error}") from None
    print(report(cases))
    content = {
        "learnt": {"elsewhere": float(f"{elsewhere:.3g}")},
        "command": "python -m acf_jax blind --out RUN --seed SEED --cases CASES; python -m validation.calibrate RUN",
        "runs": [{"seed": s["seed"], "cases": s["cases"]} for s in started],
        "commit": subprocess.run(
            ["git", "rev-parse", "HEAD"], capture_output=True, text=True, check=True
        ).stdout.strip(),
    }
    text = json.dumps(content, indent=1) + "\n"
    print(text)
    if not chosen.no_write:
        write_text(FILE, text)


if __name__ == "__main__":
    main()

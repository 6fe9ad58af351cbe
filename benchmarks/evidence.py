"""What the fits of a blind run left, and what was true: read from the run, or from a file that keeps it.

    python -m benchmarks.evidence RUN FILE.jsonl.gz

keeps the evidence of a scored run in a file of a few hundred kilobytes, a line for each data set. Those of past
reference runs lie in benchmarks/kept/, for benchmarks/fit_weights.py.
"""

import argparse
import gzip
import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from acf_jax.blind.answer import Answer
from acf_jax.blind.plan import WEAK
from acf_jax.blind.seal import open_answers
from acf_jax.diagnosis.score import UNKNOWN, Evidence
from acf_jax.effects import library


class Case(NamedTuple):
    """What a case's fits left, and what was true."""

    name: str
    kind: str  # "none", "weak", "clear", "pair" or "unknown"
    evidence: Sequence[Evidence]
    samples: int
    noise_doubt: float
    right: frozenset[tuple[str, ...]]  # explanations that count as the truth
    components: frozenset[str]  # where the cause acts


def read_cases(path: Path) -> list[Case]:
    """The cases of a blind run's folder, or of a file that keeps them."""
    return _read_file(path) if path.is_file() else _read_run(path)


def _read_run(run: Path) -> list[Case]:
    """Only of a run that has been scored: reading opens the answers, which ends a run."""
    if not (run / "results" / "score.json").exists():
        raise SystemExit(f"{run}: is not scored yet; finish `python -m acf_jax blind --out {run}` first")
    names = sorted(p.parent.name for p in (run / "results").glob("*/diagnosis.json"))
    answers = open_answers(run / "sets", run / "results", names)
    cases = []
    for name in names:
        content = json.loads((run / "results" / name / "diagnosis.json").read_text("utf-8"))
        if "evidence" in content:
            cases.append(_case(name, content["evidence"], answers[name]))
    return cases


def _case(name: str, content: dict[str, Any], answer: Answer) -> Case:
    found = [
        Evidence(tuple(f["effects"]), f["chi_square"], tuple(f["rig_strain"]), f.get("log_volume"))
        for f in content["fits"]
    ]
    truth = tuple(sorted(answer.effects))
    components = answer.components or [library()[n].component for n in truth if n in library()]
    if answer.withheld or any(n not in library() for n in truth):
        kind, right = "unknown", {UNKNOWN, *((n,) for n in answer.neighbours)}
    else:
        single = "clear" if (answer.whitened_distance or 0.0) >= WEAK[1] else "weak"
        kind, right = ("none", single, "pair")[len(truth)], {truth}
    doubt = content.get("noise_doubt", 0.0)
    return Case(name, kind, found, content["samples"], doubt, frozenset(right), frozenset(components))


def _read_file(path: Path) -> list[Case]:
    cases = []
    with gzip.open(path, "rt", encoding="utf-8") as lines:
        for line in lines:
            c = json.loads(line)
            c["evidence"] = [Evidence(tuple(n), chi2, tuple(rig), v) for n, chi2, rig, v in c["evidence"]]
            c["right"], c["components"] = frozenset(map(tuple, c["right"])), frozenset(c["components"])
            cases.append(Case(**c))
    return cases


def keep(cases: Iterable[Case], path: Path) -> None:
    """Write the cases to a file, chi-squares to the hundredth."""
    # neither name nor time in the file's head: the same cases give the same bytes
    with path.open("wb") as raw, gzip.GzipFile("", "wb", 9, raw, mtime=0) as file:
        for case in cases:
            shown = case._asdict()
            shown["evidence"] = [
                (e.explanation, round(e.chi_square, 2), [round(s, 3) for s in e.strain], _rounded(e.volume))
                for e in case.evidence
            ]
            shown["right"], shown["components"] = sorted(case.right), sorted(case.components)
            file.write((json.dumps(shown, separators=(",", ":")) + "\n").encode())


def _rounded(volume: float | None) -> float | None:
    return None if volume is None else round(volume, 3)


def main() -> None:
    """Keep the evidence of a run."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("run", type=Path)
    parser.add_argument("file", type=Path)
    chosen = parser.parse_args()
    keep(read_cases(chosen.run), chosen.file)


if __name__ == "__main__":
    main()

"""What the fits of a blind run left, and what was true: read from the run, or from a file that keeps it.

    python -m benchmarks.evidence RUN FILE.jsonl.gz

keeps the evidence of a scored run in a file of a few hundred kilobytes, a line for each data set. Those of past
reference runs lie in benchmarks/kept/, for benchmarks/fit_weights.py.
"""

import argparse
import gzip
import json
from collections.abc import Iterable, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple

from acf_jax.documents import parse_json
from acf_jax.errors import InputError
from acf_jax.evidence.posterior import UNKNOWN
from acf_jax.evidence.scores import Evidence
from acf_jax.files import MAX_BYTES, read_bytes, read_json_mapping, text_of, unpacked, write_bytes


class Case(NamedTuple):
    """What a case's fits left, and what was true."""

    name: str
    kind: str  # "none", "weak", "clear", "pair", "unknown" or "lifelike"
    evidence: Sequence[Evidence]
    samples: int
    noise_doubt: float
    right: frozenset[tuple[str, ...]]  # explanations that count as the truth
    components: frozenset[str]  # where the cause acts


def read_cases(path: Path) -> list[Case]:
    """The cases of a blind run's folder, or of a file that keeps them; ends with a message where it is neither."""
    try:
        return _read_file(path) if path.is_file() else _read_run(path)
    except InputError as error:
        raise SystemExit(f"error: {error}") from None


def _read_run(run: Path) -> list[Case]:
    """What was true is taken from the score: it says what counts as right."""
    again = f"finish `python -m acf_jax blind --out {run}` first"
    results = run / "results"
    if not run.is_dir():
        raise InputError(
            f"{run}: no such file or folder; name a scored run's folder, or a file of benchmarks/kept/"
        )
    if not (results / "score.json").exists():
        raise InputError(f"{run}: is not scored yet; {again}")
    cases = []
    for row in read_json_mapping(results / "score.json", again)["rows"]:
        if "error" not in row:
            content = read_json_mapping(results / row["set"] / "diagnosis.json", again)
            cases.append(_case(row, content["evidence"]))
    return cases


def _case(row: dict[str, Any], content: dict[str, Any]) -> Case:
    found = [
        Evidence(
            tuple(f["effects"]),
            f["chi_square"],
            tuple(f["rig_strain"]),
            f["log_volume"],
            f.get("optimism", 0.0),
        )
        for f in content["fits"]
    ]
    truth, kind = tuple(row["truth"]), row["kind"]
    # of a lifelike rig small effects may be named as well
    small = [] if truth == UNKNOWN else row.get("background", [])
    right = {tuple(sorted(truth + some)) for n in range(len(small) + 1) for some in combinations(small, n)}
    if truth == UNKNOWN:
        right |= {(name,) for name in row["neighbours"]}
    if truth == UNKNOWN and kind != "lifelike":
        kind = "unknown"
    elif kind == "single":
        kind = "clear" if row["clear"] else "weak"
    components = frozenset(row["components"])
    return Case(
        row["set"], kind, found, content["samples"], content["noise_doubt"], frozenset(right), components
    )


def _read_file(path: Path) -> list[Case]:
    cases = []
    try:
        for line in text_of(unpacked(read_bytes(path), path, "", MAX_BYTES), path).splitlines():
            c = parse_json(line, path, "")
            c["evidence"] = [
                Evidence(tuple(n), chi2, tuple(rig), *more) for n, chi2, rig, *more in c["evidence"]
            ]
            c["right"], c["components"] = frozenset(map(tuple, c["right"])), frozenset(c["components"])
            cases.append(Case(**c))
    except (ValueError, KeyError, TypeError):  # an InputError is a ValueError
        raise InputError(
            f"{path}: holds no evidence; name a run's folder, or a file that `python -m benchmarks.evidence` made"
        ) from None
    return cases


def keep(cases: Iterable[Case], path: Path) -> None:
    """Write the cases to a file, chi-squares to the hundredth; the same cases give the same bytes."""
    lines = []
    for case in cases:
        shown = case._asdict()
        shown["evidence"] = [
            (
                e.explanation,
                round(e.chi_square, 2),
                [round(s, 3) for s in e.strain],
                _rounded(e.volume),
                round(e.optimism, 2),
            )
            for e in case.evidence
        ]
        shown["right"], shown["components"] = sorted(case.right), sorted(case.components)
        lines.append(json.dumps(shown, separators=(",", ":")) + "\n")
    write_bytes(path, gzip.compress("".join(lines).encode(), mtime=0))


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

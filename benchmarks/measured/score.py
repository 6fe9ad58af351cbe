"""The diagnosis of each built set by the ordinary command, one after the other, and the table of what was right."""

import json
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from acf_jax.dataset import read_dataset
from acf_jax.documents import parse_json
from acf_jax.errors import InputError
from acf_jax.files import write_text
from benchmarks.measured.answers import OUTCOMES, outcome, read_answers
from validation.blind.answer import SECONDS, read_seconds

LONGEST = 1800.0  # s that one diagnosis may take


def score(sets: Path, out: Path, only: Sequence[str] | None = None, told: bool = False) -> None:
    """Diagnose what is not diagnosed yet, then write results.json and table.md.

    **Arguments:** `sets`: what `build` wrote; `only`: names of rigs or sets, all where None. `told`: whether the
    diagnosis is told what a rig does not have, as its owner would.

    **Raises:** `InputError` where there is no set, the answers are not those that were frozen, or, after all others, a
    diagnosis gave none.
    """
    answers = read_answers()
    rows: list[dict[str, Any]] = []
    failed: list[str] = []
    for folder in sorted(path.parent for path in sets.glob("*/*/dataset.yaml")):
        rig, name = folder.parent.name, folder.name
        if name not in answers or (only and rig not in only and name not in only):
            continue
        try:
            _diagnose(folder, out / rig / name, answers[name].without if told else ())
        except InputError as error:  # one set without an answer is no reason to lose the others
            failed += error.faults
            continue
        rows.append(_row(rig, name, len(read_dataset(folder).trials), out / rig / name, answers[name]))
        print(_line(rows[-1]), flush=True)
    if not rows and not failed:
        raise InputError([f"{sets} holds no set that has an answer; write them with `build`"])
    write_text(out / "results.json", json.dumps(rows, indent=1) + "\n")
    write_text(out / "table.md", table(rows))
    print("\n" + table(rows))
    if failed:
        raise InputError(failed)


def _diagnose(folder: Path, out: Path, without: Sequence[str]) -> None:
    """Run `diagnose` unless its result is there."""
    if (out / "diagnosis.json").is_file():
        return
    began = time.monotonic()
    command = [sys.executable, "-m", "acf_jax", "diagnose", str(folder), "--out", str(out)]
    command += [word for name in without for word in ("--without", name)]
    try:
        subprocess.run(command, timeout=LONGEST, capture_output=True, text=True, check=True)
    except subprocess.CalledProcessError as error:
        raise InputError([f"{folder}: {error.stderr.strip()}"]) from error
    except subprocess.TimeoutExpired as error:
        raise InputError([f"{folder}: no answer after {LONGEST:.0f} s; build a smaller set"]) from error
    write_text(out / SECONDS, f"{time.monotonic() - began:.1f}\n")


def _row(rig: str, name: str, trials: int, result: Path, answer: Any) -> dict[str, Any]:
    path = result / "diagnosis.json"
    found = parse_json(path.read_text("utf-8"), path, "diagnose the set again")
    first = found["explanations"][0]
    return {
        "rig": rig,
        "set": name,
        "trials": trials,
        "injected": answer.injected,
        "known": answer.known,
        "verdict": found["verdict"],
        "first": first["effects"],
        "probability": first["probability"],
        "component": found["where"]["component"],
        "excluded": [entry["trial"] for entry in found["excluded_trials"]],
        "gap": found["gap"],
        "outcome": outcome(answer, found),
        "seconds": read_seconds(result),
    }


def _line(row: dict[str, Any]) -> str:
    said = " and ".join(row["first"]) or "nothing unmodelled"
    took = "" if row["seconds"] is None else f", {row['seconds']:.0f} s"
    return f"{row['set']}: {row['outcome']} ({row['verdict']}: {said} {row['probability']:.2f}{took})"


def table(rows: Sequence[dict[str, Any]]) -> str:
    """How many sets of each rig were right, as Markdown; those with an injected cause apart."""
    lines = [
        "| rig | sets | trials | " + " | ".join(OUTCOMES) + " |",
        "|---|---|---|" + "---|" * len(OUTCOMES),
    ]
    for injected in (False, True):
        counted = [row for row in rows if row["injected"] is injected]
        for rig in dict.fromkeys(row["rig"] for row in counted):
            lines.append(_sums(rig, [row for row in counted if row["rig"] == rig], injected))
        if counted:
            lines.append(_sums("all", counted, injected))
    return "\n".join(lines) + "\n"


def _sums(name: str, rows: Sequence[dict[str, Any]], injected: bool) -> str:
    counts = Counter(row["outcome"] for row in rows)
    cells = [str(counts[o]) for o in OUTCOMES]
    label = f"{name}, injected" if injected else name
    return f"| {label} | {len(rows)} | {sum(row['trials'] for row in rows)} | {' | '.join(cells)} |"

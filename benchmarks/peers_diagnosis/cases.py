"""What every method is asked: data sets whose cause is known, with our diagnosis of each."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from acf_jax.dataset import data_sets
from acf_jax.errors import InputError
from acf_jax.evidence.marginal import Marginal, read_evidence
from acf_jax.files import read_json_mapping
from benchmarks.measured.answers import Answer as Known
from benchmarks.measured.answers import read_answers
from validation.blind.answer import (
    ANSWER,
    DIAGNOSIS,
    Answer,
    Class,
    Failed,
    Said,
    read_answer,
    read_said,
    read_seconds,
)
from validation.blind.campaign import WITHHELD
from validation.blind.score import UNKNOWN, asked

Explanation = tuple[str, ...]
SCORE = "score.json"


@dataclass(frozen=True)
class Named:
    """What a method said of a data set: explanations with their probabilities, most probable first.

    `is_sure`: the method gives one answer and no probability.
    """

    scored: tuple[tuple[Explanation, float], ...]
    seconds: float
    is_sure: bool = False


@dataclass(frozen=True)
class Case:
    """A data set with its answer, and what our diagnosis made of it."""

    name: str
    kind: str  # "none", "single", "pair", "unknown", "lifelike" or "measured"
    data: Path
    ours: Named
    evidence: tuple[Marginal, ...]  # the fits of our diagnosis
    known: Known | None = None  # of a measured set, in place of all that follows
    truth: tuple[str, ...] = ()
    background: tuple[str, ...] = ()  # small effects, which may be named as well
    neighbours: dict[str, float] = field(default_factory=dict)  # of an unknown cause: what imitates it
    withheld: str = ""  # the effect that no method shall know
    classes: tuple[Class, ...] = ()  # what these trials cannot tell apart


def read_run(run: Path) -> list[Case]:
    """The cases of a scored blind run; `InputError` where it is not scored or damaged."""
    return read_cases(run / "sets", run / "results")


def read_measured(sets: Path, results: Path) -> list[Case]:
    """The cases that `python -m benchmarks.measured` built and scored, but for those that ask for faulty trials.

    Those of peaks alone are left out as well: not every method reads them.

    **Raises:** `InputError` where there is none, or diagnoses or their evidence are damaged.
    """
    cases = []
    for name, known in read_answers().items():
        for found in results.glob(f"*/{name}/{DIAGNOSIS}"):
            said = read_said(found.parent)
            is_asked = "excluded" not in known.right and _has_traces(found)
            if is_asked and not isinstance(said, Failed):
                cases.append(
                    Case(
                        name=name,
                        kind="measured",
                        data=sets / found.parent.relative_to(results),
                        ours=Named(_scored(said), _seconds(found.parent)),
                        evidence=read_evidence(found),
                        known=known,
                    )
                )
    if not cases:
        raise InputError(
            f"{results}: holds no diagnosis of a measured set; run `python -m benchmarks.measured score` first"
        )
    return cases


def read_cases(sets: Path, results: Path) -> list[Case]:
    """The cases of a folder of data sets whose diagnoses lie in `results`.

    The truth is taken from `results/score.json`, or without it from an `answer.yaml` beside each data set.

    **Raises:** `InputError` where answers, diagnoses or their evidence are missing or damaged.
    """
    if not sets.is_dir() or not results.is_dir():
        missing = results if sets.is_dir() else sets
        raise InputError(f"{missing}: no such folder; name a run that `python -m acf_jax blind` finished")
    rows = _rows(sets, results)
    withheld: dict[str, Any] = {}
    if (sets / WITHHELD).exists():
        withheld = read_json_mapping(sets / WITHHELD, "draw the run again")
    cases = []
    for row in rows:
        name = row["set"]
        said = read_said(results / name)
        if not isinstance(said, Failed):
            cases.append(
                Case(
                    name=name,
                    kind=_kind(row),
                    data=sets / name,
                    truth=tuple(row["truth"]),
                    background=tuple(row["background"]),
                    neighbours=row["neighbours"],
                    withheld=str(withheld.get(name, "")),
                    classes=said.indistinguishable,
                    ours=Named(_scored(said), _seconds(results / name)),
                    evidence=read_evidence(results / name / DIAGNOSIS),
                )
            )
    if not cases:
        raise InputError(f"{results}: holds no diagnosis that could be made; name another run")
    return cases


def _has_traces(document: Path) -> bool:
    """Of peaks alone no diagnosis states an error of the force."""
    gap = read_json_mapping(document, "diagnose again").get("gap") or {"nominal": {}}
    return gap["nominal"].get("force_rms_n", 0.0) is not None


def _scored(said: Said) -> tuple[tuple[Explanation, float], ...]:
    return tuple((tuple(sorted(e.effects)), e.probability) for e in said.explanations)


def _rows(sets: Path, results: Path) -> Sequence[dict[str, Any]]:
    path = results / SCORE
    if path.exists():
        again = f"remove it, and score {sets} again"
        rows = read_json_mapping(path, again).get("rows")
        keys = {"set", "kind", "truth", "background", "neighbours"}
        if not isinstance(rows, list) or not all(isinstance(r, dict) and keys <= r.keys() for r in rows):
            raise InputError(f"{path}: rows: must hold {', '.join(sorted(keys))} each; {again}")
        return rows
    names = data_sets(sets)
    if missing := [name for name in names if not (sets / name / ANSWER).exists()]:
        raise InputError(
            f"{sets / missing[0]}: has no {ANSWER}, and {path} does not exist;"
            " score the run first, or write the answer beside the data set"
        )
    answers: dict[str, Answer] = {name: read_answer(sets / name) for name in names}
    return [asked(name, answer) for name, answer in answers.items()]


def _kind(row: dict[str, Any]) -> str:
    is_plain_unknown = row["truth"] == UNKNOWN and row["kind"] != "lifelike"
    return "unknown" if is_plain_unknown else str(row["kind"])


def _seconds(result: Path) -> float:
    seconds = read_seconds(result)
    return float("nan") if seconds is None else seconds

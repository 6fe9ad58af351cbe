"""The comparison as Markdown: every method over the same cases, paired with our diagnosis."""

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.peers_diagnosis.cases import Case
from benchmarks.peers_diagnosis.judge import Figure, Outcome, paired, share

OURS = "ours"
KINDS = ("none", "single", "pair", "unknown", "lifelike", "measured")


def table(cases: Sequence[Case], outcomes: Mapping[str, Sequence[Outcome]]) -> str:
    """One row a method, `ours` first: figures with 95 % intervals, and their paired differences to ours."""
    kinds = [kind for kind in KINDS if any(case.kind == kind for case in cases)]
    head = ["method", "right", "less ours", "wrong name when sure", "log loss", "less ours", "s a set"]
    lines = ["| " + " | ".join([*head, *kinds]) + " |", "|---" * (len(head) + len(kinds)) + "|"]
    ours = outcomes[OURS]
    for method, found in outcomes.items():
        right = [o.right for o in found]
        loss = [o.log_loss for o in found]
        has_loss = bool(np.isfinite(loss).all())
        cells = [
            method,
            f"{sum(right)}/{len(right)} ({_percent(share(right))})",
            "" if method == OURS else _points(paired(right, [o.right for o in ours])),
            f"{sum(o.wrong_when_sure for o in found)}/{len(found)}",
            f"{np.mean(loss):.2f}" if has_loss else "-",
            _signed(paired(loss, [o.log_loss for o in ours])) if has_loss and method != OURS else "",
            _seconds([o.seconds for o in found]),
        ]
        for kind in kinds:
            of_kind = [o.right for case, o in zip(cases, found, strict=True) if case.kind == kind]
            cells.append(f"{sum(of_kind)}/{len(of_kind)}")
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def lines(
    cases: Sequence[Case], outcomes: Mapping[str, Sequence[Outcome]], said: Mapping[str, Sequence[str]]
) -> str:
    """One line a case: its cause, and what each method said."""
    text = []
    for k, case in enumerate(cases):
        answers = [
            f"{method} {'right' if found[k].right else 'MISS'} {said[method][k]}"
            for method, found in outcomes.items()
        ]
        cause = case.known.known if case.known else "+".join(case.truth) or "none"
        text.append(f"{case.name} {case.kind} ({cause}): " + ", ".join(answers))
    return "\n".join(text) + "\n"


def _percent(f: Figure) -> str:
    return f"{f.low:.0%} to {f.high:.0%}"


def _points(f: Figure) -> str:
    return f"{100 * f.value:+.0f} ({100 * f.low:+.0f} to {100 * f.high:+.0f}) points"


def _signed(f: Figure) -> str:
    return f"{f.value:+.2f} ({f.low:+.2f} to {f.high:+.2f})"


def _seconds(seconds: Sequence[float]) -> str:
    known = [s for s in seconds if np.isfinite(s)]
    return f"{np.median(known):.3g}" if known else "-"

"""Step 5, Diagnose: the report as it fills, from what a running diagnosis has told so far."""

from collections import ChainMap
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from acf_jax.report.markup import Html, element, table
from acf_jax.report.trusted import headed_by
from acf_jax.report.words import headed, name_of, si

SHOWN = 8  # explanations, the best so far
MODELS = {"nominal": "as stated", "recalibrated": "refitted to these trials"}


def known_so_far(known: Sequence[Mapping[str, Any]]) -> Html:
    """Data trust, the paper's model before and after a refit, and the explanations weighed so far."""
    told = ChainMap(*map(dict, reversed(known)))  # a part that is told again replaces the one before
    try:
        parts = [html for name, part in PARTS.items() if name in told for html in part(told[name])]
    except (AttributeError, LookupError, TypeError, ValueError):
        return Html("")  # a damaged line of a file; the report comes from elsewhere
    if not parts:
        return Html("")
    head = element("h2", "Known so far", id="known-title")
    note = element("p", "Provisional: the answer is the report, which comes at the end.", class_="muted")
    return element("section", head, note, *parts, aria_labelledby="known-title", id="known-so-far")


def _trust(part: Mapping[str, Any]) -> list[Html]:
    return [headed_by(str(part["headline"]), [str(line) for line in part["limits"]])]


def _gap(part: Mapping[str, Any]) -> list[Html]:
    rows = [
        (word, _figure(part[name]["force_rms_n"], "N"), _figure(part[name]["peak_rms_percent"], "%"))
        for name, word in MODELS.items()
    ]
    caption = "How far the paper's model misses these trials"
    return [table(caption, ("Its parameters", "Force, RMS", "Peak, RMS"), rows)]


def _evidence(part: Sequence[Mapping[str, Any]]) -> list[Html]:
    rows = [
        (headed(name_of(tuple(one["effects"]))), f"{float(one['value']):+,.1f}".replace("-", "−"))
        for one in part
    ]
    caption = f"{len(rows)} explanations weighed so far, each against the refitted model alone"
    head = ("Explanation, the best so far first", "Log evidence, provisional")
    more = element("p", f"and {len(rows) - SHOWN} more", class_="muted") if len(rows) > SHOWN else Html("")
    return [table(caption, head, rows[:SHOWN]), more]


def _figure(value: float | None, unit: str) -> str:
    return "–" if value is None else si(float(value), 3, unit)


PARTS: dict[str, Callable[[Any], list[Html]]] = {"trust": _trust, "gap": _gap, "log_evidence": _evidence}

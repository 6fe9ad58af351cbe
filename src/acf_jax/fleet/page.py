"""`index.html`: all rigs on one self-contained page, what changed first."""

from collections import Counter
from collections.abc import Sequence
from urllib.parse import quote

from acf_jax import __version__
from acf_jax.fleet import figures
from acf_jax.fleet.changes import CAUSE, Trend
from acf_jax.fleet.record import Change, Fleet, Rig
from acf_jax.report.markup import Html, bullets, element, join, sortable_table, table
from acf_jax.report.page import page, part
from acf_jax.report.words import VERDICTS, listed, name_of, percent


def fleet_page(fleet: Fleet, trends: Sequence[Trend], origin: str = "") -> str:
    """The page of a run; `trends` as `find_changes` gives them, `origin`: how the run came about."""
    rigs = [rig for rig in fleet.rigs if not rig.fault]
    faults = [_fault(rig.rig, line) for rig in fleet.rigs for line in rig.fault.splitlines()]
    faults += [_fault(name, f"in {fleet.since[-1]}, but not among these data sets") for name in fleet.missing]
    parts = [
        part("changes", "What changed", "What changed", _changes(fleet), figures.trend(fleet, trends)),
        part("faults", "No diagnosis", "Rigs without a diagnosis", bullets(faults) if faults else None),
        part(
            "overview",
            "Overview",
            "Which gap, and what is left of it",
            figures.causes(rigs),
            figures.gaps(rigs),
        ),
        part("rigs", "All rigs", "All rigs", _table(rigs) if rigs else None),
    ]
    foot = element(
        "p",
        f"acf-jax {__version__}. The figures are those of fleet.json beside this page and of each rig's diagnosis.json;"
        f" force and peak errors are on conditions that the fit did not see. {origin}",
        class_="muted",
    )
    return page(f"Fleet: {fleet.label}", _head(fleet, rigs), [p for p in parts if p], foot)


def _fault(rig: str, what: str) -> Html:
    return element("span", element("strong", rig), ": ", what)


def _head(fleet: Fleet, rigs: Sequence[Rig]) -> Html:
    counts = Counter(rig.verdict for rig in rigs)
    changed = len({change.rig for change in fleet.changes})
    said = f"{_count(len(fleet.rigs), 'rig')}"
    if fleet.since:
        said += f", {changed or 'none'} of them changed, compared with {listed(fleet.since)}"
    tiles = [
        element("div", element("dt", VERDICTS[name][0]), element("dd", counts[name], class_="value"))
        for name in VERDICTS
        if counts[name]
    ]
    if missing := len(fleet.rigs) - len(rigs):
        tiles.append(
            element("div", element("dt", "No diagnosis"), element("dd", missing, class_="value bad"))
        )
    title = element("h1", f"Sim-to-real gaps of the fleet {fleet.label}")
    made = element("p", fleet.finished, class_="muted")
    return join(
        [title, element("p", f"{said}.", class_="verdict"), element("dl", *tiles, class_="tiles"), made]
    )


def _changes(fleet: Fleet) -> Html | None:
    if not fleet.since:
        return None
    if not fleet.changes:
        return element("p", f"Nothing beyond what chance explains, compared with {listed(fleet.since)}.")
    rows = [
        (
            _link(change.rig),
            _what(change),
            change.before,
            change.after,
            "" if change.sigmas is None else f"{change.sigmas:+.1f} σ".replace("-", "−"),
        )
        for change in fleet.changes
    ]
    return table(
        "Changes, causes first, then the surest trends", ["Rig", "What", "Before", "Now", "Trend"], rows
    )


def _what(change: Change) -> Html:
    if change.what == CAUSE:
        return element("span", "most probable cause")
    grows = "grows" if (change.sigmas or 0) > 0 else "falls"
    return element("span", element("code", change.what), f" {grows}")


def _table(rigs: Sequence[Rig]) -> Html:
    rows: list[list[tuple[object, str | float | None]]] = []
    for rig in rigs:
        tag, mood = VERDICTS[rig.verdict]
        rows.append(
            [
                (_link(rig.rig), rig.rig),
                (element("span", tag, class_=f"tag {mood}"), list(VERDICTS).index(rig.verdict)),
                (_explanation(rig), " ".join(rig.first)),
                (percent(rig.probability), rig.probability),
                (rig.component or "–", rig.component or ""),
                (_number(rig.recalibrated_rms_n, "N"), rig.recalibrated_rms_n),
                (_number(rig.corrected_rms_n, "N"), rig.corrected_rms_n),
                (_number(rig.peak_rms_percent, "%"), rig.peak_rms_percent),
                (percent(rig.shrinkage), rig.shrinkage),
                (rig.warnings or "–", rig.warnings),
            ]
        )
    head = (
        "Rig",
        "Verdict",
        "First explanation",
        "Probability of the first",
        "Acts at",
        "Force error before",
        "Force error after",
        "Peak error",
        "Gap removed",
        "Warnings",
    )
    return sortable_table("The name leads to the rig's report; a column's name sorts by it.", head, rows)


def _explanation(rig: Rig) -> str:
    """The first explanation, or all of a class that these trials cannot tell apart, where it is identified."""
    alike = rig.credible if rig.verdict == "identified" else ()
    return listed([name_of(effects) for effects in alike or (rig.first,)], "or")


def _link(rig: str) -> Html:
    return element("a", rig, href=f"{quote(rig)}/report.html")


def _number(value: float | None, unit: str) -> str:
    return "–" if value is None else f"{value:.3g} {unit}"


def _count(n: int, noun: str) -> str:
    return f"{n} {noun}" + ("" if n == 1 else "s")

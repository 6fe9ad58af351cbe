"""Step 5, Diagnose: progress, cancel, and the report that `diagnose` writes."""

import csv
import json
from collections.abc import Sequence
from itertools import pairwise

from starlette.responses import Response

from acf_jax.app import jobs
from acf_jax.app.current import diagnosed_by
from acf_jax.app.pages.layout import (
    button,
    embedded,
    faults_box,
    form,
    hidden,
    job_panel,
    note,
    outdated,
    page,
    running,
)
from acf_jax.app.pages.provisional import known_so_far
from acf_jax.app.sessions import DATA, DIAGNOSIS, Session
from acf_jax.report.markup import Html, element, table, void
from acf_jax.report.plot import Variant, axis, plot, series
from acf_jax.report.words import condition, headed

TRACES = 60  # that are drawn while a diagnosis runs


def diagnosing(session: Session, faults: Sequence[str] = ()) -> Response:
    """The page."""
    job = jobs.job(session.folder, "diagnose")
    busy = running(session)
    body: list[object] = [faults_box(faults), job_panel(session, busy or job)]
    if busy and busy.kind == "diagnose":
        body.append(known_so_far(busy.known))
    if not session.is_imported:
        body.append(
            note("No data set yet: ", element("a", "cut a recording", href=f"{session.url}/cut"), " first.")
        )
    elif not session.has_rig:
        body.append(
            note(
                element("a", "Describe the rig", href=f"{session.url}/rig"),
                " first: a diagnosis compares with it.",
            )
        )
    elif busy is None:
        body.append(_start(session))
    if busy is None and session.has(DIAGNOSIS, "report.html"):
        body.append(outdated(session))
        onward = element("a", "Use the corrected model", href=f"{session.url}/use", class_="button first")
        body.append(element("p", onward))
        body.append(embedded(f"{session.url}/file/{DIAGNOSIS}/report.html", "Report"))
    elif session.is_imported and (busy or not session.is_diagnosed):
        body.append(_data(session))
    return page("Diagnose", *body, session=session, step="diagnose")


def without_of(session: Session) -> list[str]:
    """The causes, and components, that the last diagnosis was told to leave out."""
    job = jobs.job(session.folder, "diagnose")
    if job is None:
        return diagnosed_by(session)[0]
    command = job.command
    return [name for option, name in pairwise(command) if option == "--without"]


def _start(session: Session) -> Html:
    """The button, and the causes that cannot be on this rig."""
    from acf_jax.effects import library

    off = set(without_of(session))
    boxes = [
        element(
            "li",
            void(
                "input",
                type="checkbox",
                name="cause",
                value=name,
                id=f"cause-{name}",
                checked=off.isdisjoint((name, cls.component)),
            ),
            element("label", f" {cls.title}", for_=f"cause-{name}"),
        )
        for name, cls in library().items()
    ]
    causes = element(
        "details",
        element("summary", "Causes that may act on this rig"),
        element("p", "Switch off what cannot be: a rig without a pad has no pad mass."),
        element("ul", *boxes, class_="columns"),
        open=bool(off),
    )
    word = "Diagnose again" if session.is_diagnosed else "Diagnose"
    told = element(
        "p",
        "Takes about half a minute, several minutes for rigs with many small effects. It goes on when this page is"
        " closed.",
        class_="muted",
    )
    return form(
        f"{session.url}/diagnose",
        causes,
        hidden("sent", 1),
        button(word, class_=None if session.is_diagnosed else "first"),
        told,
    )


def _data(session: Session) -> Html:
    """What is diagnosed: the trials with their traces."""
    try:
        with (session.folder / DATA / "trials.csv").open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))[:TRACES]
        lines = [line for row in rows if (line := _trace(session, row))]
        shown = [
            (
                row["trial"],
                condition(float(row["contact_velocity_m_per_s"]), float(row["pretension_n"])),
                row.get("peak_force_n") or "–",
            )
            for row in rows
        ]
    except (OSError, ValueError, LookupError, TypeError):
        return note("The data set cannot be shown: diagnosing it tells what is wrong with it.")
    layout = {
        "xaxis": axis("time since contact / ms"),
        "yaxis": axis("sensed force / N"),
        "showlegend": False,
    }
    figure = plot("trials", "The trials", "", [Variant("", lines)], layout, 320) if lines else Html("")
    named = element(
        "details",
        element("summary", f"{len(rows)} trials"),
        table("As imported", ("Trial", "Condition", "Peak, N"), shown),
    )
    return element(
        "section",
        element("h2", "What is diagnosed", id="data-title"),
        figure,
        named,
        aria_labelledby="data-title",
    )


def _trace(session: Session, row: dict[str, str]) -> dict[str, object] | None:
    import numpy as np

    from acf_jax.files import inside, read_text

    if not row.get("trace"):
        return None
    text = read_text(inside(session.folder / DATA, row["trace"]))
    values = np.array([line.split(",")[:2] for line in text.splitlines()[1:] if line], float)
    step = max(1, len(values) // 400)
    return {"type": "scatter", "mode": "lines", "x": series(1e3 * values[::step, 0], 5), "y": series(values[::step, 1]),
            "name": headed(row["trial"]), "line": {"width": 1, "color": "--recalibrated"}, "opacity": 0.7,
            "hoverinfo": "skip"}  # fmt: skip


def verdict_of(session: Session) -> str | None:
    """The verdict of the session's diagnosis; None where there is none."""
    try:
        return str(json.loads((session.folder / DIAGNOSIS / "diagnosis.json").read_text("utf-8"))["verdict"])
    except (OSError, ValueError, LookupError, TypeError):
        return None

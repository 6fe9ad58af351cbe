"""Step 1, Open: what the recording holds, and which of its signals are force, speed and pretension."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from starlette.responses import Response

from acf_jax.app import signals
from acf_jax.app.look import look
from acf_jax.app.pages.layout import (
    button,
    faults_box,
    form,
    job_panel,
    note,
    page,
    running,
)
from acf_jax.app.pages.roles import called, signals_form
from acf_jax.app.sessions import MAPPING, UPLOADED, Session
from acf_jax.errors import InputError
from acf_jax.report.markup import Html, element
from acf_jax.report.plot import Variant, axis, plot


def opening(session: Session, faults: Sequence[str] = ()) -> Response:
    """The page."""
    recording = session.recording()
    job = running(session)
    if recording is None:
        return page(
            "Open",
            faults_box(faults),
            _no_recording(session),
            session=session,
            step="open",
            scripts=("open.js",),
        )
    try:
        content = signals.read(session.folder / MAPPING)
    except InputError as error:
        return page(
            "Open", faults_box(error.faults, "mapping.yaml"), session=session, step="open", status=400
        )
    offered = offers(session)
    robot = session.recording("robot")
    name = session.name if recording == Path(UPLOADED) else recording.name  # the folder of a bag
    told = element(
        "p", element("strong", name), f" and {robot.name}" if robot else "", f" · {_size(session)}"
    )
    faults = [*faults, *offered["faults"], *offered.get("obstacles", [])]
    return page(
        "Open",
        job_panel(session, job),
        faults_box(faults, "Of this recording"),
        told,
        element(
            "div",
            element("section", element("h2", "Signals", id="signals-title"), signals_form(session, content, offered),
                    aria_labelledby="signals-title"),
            element("section", element("h2", "What it holds", id="tree-title"), _tree(offered), _preview(session),
                    aria_labelledby="tree-title"),
            class_="beside",
        ),
        _other(session),
        session=session,
        step="open",
        scripts=("open.js",),
    )  # fmt: skip


def offers(session: Session) -> dict[str, Any]:
    """What the recordings of a session offer."""
    recording, robot = session.recording(), session.recording("robot")
    mapping = MAPPING if session.has(MAPPING) else ""
    if recording is None:
        return {"faults": [], "channels": [], "candidates": {}}
    first = look(session.folder, "list", str(recording), mapping)
    if robot is None or first["faults"]:
        return first
    other = look(session.folder, "list", str(robot))
    there = other.get("candidates", {})
    candidates = {
        role: there.get(role) or first["candidates"].get(role, []) for role in ("velocity", "pretension")
    }
    return {
        "faults": [*first["faults"], *other["faults"]],
        "obstacles": [*first.get("obstacles", []), *other.get("obstacles", [])],
        "channels": [*first["channels"], *({**c, "robot": True} for c in other.get("channels", []))],
        "candidates": candidates | {"force": first["candidates"].get("force", [])},
    }


def preview(session: Session, which: str, name: str, field_name: str) -> dict[str, Any]:
    """One signal, for the page's figure."""
    recording = session.recording("robot" if which == "robot" else "recording")
    if recording is None:
        return {"faults": ["no such recording in this session"]}
    mapping = MAPPING if session.has(MAPPING) and which != "robot" else ""
    return look(session.folder, "signal", str(recording), mapping, name, field_name)


def _tree(offered: dict[str, Any]) -> Html:
    """Channels, and below a topic its fields, each with buttons."""
    items = []
    for channel in offered.get("channels", []):
        count = f", {channel['count']:,}" if channel["count"] is not None else ""
        which = "robot" if channel.get("robot") else "recording"
        fields = channel["fields"]
        about = element("span", f" {channel['type']}{count}", class_="muted")
        if not fields:
            items.append(element("li", element("span", channel["name"], class_="leaf"), about,
                                 _buttons(which, channel["name"], None)))  # fmt: skip
            continue
        leaves = (
            element("li", element("span", f, class_="leaf"), _buttons(which, channel["name"], f))
            for f in fields
        )
        summary = element("summary", channel["name"], about)
        items.append(
            element("li", element("details", summary, element("ul", *leaves), open=len(fields) < 12))
        )
    return element("ul", *items, class_="tree") if items else note("Nothing that can be read.")


def _buttons(which: str, name: str, field_name: str | None) -> Html:
    label = called(name, field_name)
    value = signals.value_of(name, field_name)
    taken = [
        button(
            word,
            type="button",
            class_="quietly",
            data_take=role,
            data_signal=value,
            aria_label=f"{word}: take {label}",
        )
        for role, word in (("force", "force"), ("speed", "speed"), ("pretension", "pretension"))
    ]
    look_at = button(
        "look",
        type="button",
        class_="quietly",
        data_look=value,
        data_which=which,
        aria_label=f"look at {label}",
    )
    return element("span", look_at, *taken, class_="acts")


def _preview(session: Session) -> Html:
    layout = {"xaxis": axis("time / s"), "yaxis": axis("")}
    figure = plot("preview", "Preview", "", [Variant("", [])], layout, 260)
    said = element(
        "p",
        "Choose ‘look’ beside a signal.",
        id="preview-said",
        role="status",
        aria_live="polite",
        class_="muted",
    )
    return element("div", said, figure, id="preview-box", data_preview=f"{session.url}/preview")


def _other(session: Session) -> Html:
    """Further files: the robot's own recording."""
    return element(
        "details",
        element("summary", "The robot's signals are in another recording"),
        element("p", "Its clock is brought to that of the force where that is possible."),
        element(
            "p",
            element(
                "a",
                "Choose it on this machine",
                href=f"/browse/0/?session={session.place}/{quote(session.name)}",
            ),
        ),
        form(f"{session.url}/without-robot", button("Take it out")) if session.about.robot else None,
    )


def _no_recording(session: Session) -> Html:
    if session.is_imported:
        return note(
            "This session holds a data set and no recording; go on with the rig, or with the diagnosis."
        )
    return note(
        "This session has no recording yet. Describe the rig and plan trials; drop a recording on the first page."
    )


def _size(session: Session) -> str:
    recording = session.recording()
    assert recording is not None
    path = session.folder / recording
    if not path.exists():
        return "it is not there any more"
    files = [path] if path.is_file() else [f for f in path.iterdir() if f.is_file()]
    size = sum(f.stat().st_size for f in files)
    return f"{size / 1e6:.1f} MB"

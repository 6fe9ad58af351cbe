"""All sessions, and a new one: drop files, or open what is on this machine in place."""

import json
import time
from pathlib import Path
from urllib.parse import quote

from starlette.responses import Response

from acf_jax.app import sessions, uploads
from acf_jax.app.pages.layout import button, field, form, hidden, note, page
from acf_jax.app.security import Places
from acf_jax.errors import InputError
from acf_jax.recording.readers import readers
from acf_jax.report.markup import Html, element, escape, join, table, void
from acf_jax.report.words import VERDICTS

SHOWN = 500  # entries of a folder


def home(places: Places) -> Response:
    """The page."""
    found = sessions.every(places)
    rows = [(element("a", s.name, href=f"{s.url}/{_next(s)}"), _state(s), _when(s.folder)) for s in found]
    listed = table(
        "Each is a folder that the commands read, too", ("Session", "How far", "Last change"), rows
    )
    return page("Sessions", new_session(places), listed if rows else None, step="sessions")


def new_session(places: Places) -> Html:
    """Where a recording is dropped."""

    def chosen(name: str, label: str, **several: bool) -> Html:
        return field(
            label, void("input", type="file", id=name, aria_describedby="files-hint", **several), name
        )

    controls = (
        chosen("files", "Its files", multiple=True),
        chosen("folder", "Its folder", webkitdirectory=True),
    )
    drop = element(
        "div",
        element(
            "p", element("strong", "Drop a recording here"), ", a file or the folder of a bag, or choose"
        ),
        element("div", *controls, class_="row"),
        element(
            "p",
            f"ROS bag, CSV, .mat, HDF5, Parquet, TDMS, Excel, NumPy. At most {uploads.LARGEST / 1e9:g} GB a file;"
            " larger ones open in place.",
            class_="muted hint",
            id="files-hint",
        ),
        element("progress", id="upload-progress", max=1, value=0, aria_label="Upload", hidden=True),
        element("p", role="status", aria_live="polite", id="upload-said"),
        class_="drop",
        id="drop",
        data_upload="/upload",
    )
    where = ", ".join(str(folder) for folder in places.folders)
    here = element(
        "p", element("a", "Open a recording or a data set on this machine", href="/browse/0/"), class_="after"
    )
    empty = form(
        "/new",
        field(
            "Name", void("input", id="name", name="name", value="my rig", maxlength=60, required=True), "name"
        ),
        button("Start without a recording"),
        class_="row",
    )
    about = element(
        "p",
        f"Sessions are kept in {places.folders[0]}. This app reads and writes in {where} alone.",
        class_="muted",
    )
    return element(
        "section",
        element("h2", "New session", id="new-title"),
        drop,
        here,
        element("details", element("summary", "Plan first: a session without a recording"), empty),
        about,
        aria_labelledby="new-title",
    )


def browse(places: Places, place: int, relative: str, session: str = "") -> Response:
    """The files of a chosen folder, each with a button that opens it in place."""
    folder = places.resolve(place, relative)
    if not folder.is_dir():
        raise InputError(f"{relative}: is no folder; go back")
    entries = sorted(
        (e for e in folder.iterdir() if e.name[0] != "."), key=lambda e: (not e.is_dir(), e.name.lower())
    )
    query = f"?session={quote(session)}" if session else ""
    rows = []
    for entry in entries[:SHOWN]:
        if not entry.resolve().is_relative_to(places.folders[place]):
            continue  # a link that leads elsewhere
        path = str(entry.relative_to(places.folders[place]))
        name: Html = escape(entry.name)
        if entry.is_dir():
            name = element("a", f"{entry.name}/", href=f"/browse/{place}/{quote(path)}{query}")
        rows.append((name, _size(entry), _opens(place, path, entry, session)))
    up = Path(relative).parent
    above = element(
        "a", "Folder above", href=f"/browse/{place}/{quote(str(up)) if str(up) != '.' else ''}{query}"
    )
    others = [
        element("a", str(f), href=f"/browse/{i}/{query}") for i, f in enumerate(places.folders) if i != place
    ]
    more = (
        note(f"{len(entries) - SHOWN} more entries are not shown; name a smaller folder")
        if len(entries) > SHOWN
        else None
    )
    return page(
        "Open on this machine",
        element("p", element("code", str(folder))),
        element("p", above) if relative else None,
        element("p", "Other folders: ", *_between(others)) if others else None,
        table("What lies here", ("Name", "Size", "Action"), rows) if rows else note("This folder is empty."),
        more,
    )


def _between(links: list[Html]) -> list[object]:
    return [part for link in links for part in (link, " ")]


def _opens(place: int, path: str, entry: Path, session: str) -> Html:
    """The button, for whatever may be a recording or a data set."""
    is_set = entry.is_dir() and (entry / "dataset.yaml").is_file()
    if not is_set and not any(reader.recognises(entry) for reader in readers()):
        return Html("")
    word = "Open data set" if is_set else "Open"
    label = element("span", f" {entry.name}", class_="quiet")
    values = [
        hidden("place", place),
        hidden("path", path),
        *([hidden("session", session)] if session else []),
    ]
    return form("/open", *values, button(join([word, label])))


def _size(entry: Path) -> str:
    if entry.is_dir():
        return "folder"
    size = float(entry.stat().st_size)
    for unit in ("B", "kB", "MB"):
        if size < 1000:
            return f"{size:.3g} {unit}"
        size /= 1000
    return f"{size:.3g} GB"


def _next(session: sessions.Session) -> str:
    """The step that a session is at."""
    if session.is_diagnosed:
        return "diagnose"
    if session.is_imported:
        return "diagnose" if session.has_rig else "cut"
    return "open"


def _state(session: sessions.Session) -> Html:
    if not session.is_diagnosed:
        return escape("data set" if session.is_imported else "opened")
    try:
        verdict = json.loads((session.folder / "diagnosis/diagnosis.json").read_text("utf-8"))["verdict"]
        word, mood = VERDICTS[verdict]
    except (OSError, ValueError, LookupError, TypeError):
        return escape("its diagnosis.json is damaged: diagnose again")
    return element("span", word, class_=mood)


def _when(folder: Path) -> str:
    return time.strftime("%Y-%m-%d %H:%M", time.localtime(folder.stat().st_mtime))

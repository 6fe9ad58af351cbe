"""What requests have in common: the session that they name, the fields of a form, and files that are served."""

from collections.abc import Callable
from pathlib import Path
from urllib.parse import quote

from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, RedirectResponse, Response

from acf_jax.app import sessions
from acf_jax.app.security import SANDBOX, Places
from acf_jax.app.sessions import Session

SHOWN = {".html": "text/html; charset=utf-8"}  # files that a browser shows; all others it only saves

Form = dict[str, list[str]]


def show(shown: Callable[[Session], Response]) -> Callable[[Request], Response]:
    return lambda request: shown(session_of(request))


def places_of(request: Request) -> Places:
    places: Places = request.app.state.places
    return places


def session_of(request: Request) -> Session:
    return sessions.find(
        places_of(request), number(request.path_params["place"]), request.path_params["name"]
    )


def session_named(request: Request, given: str) -> Session:
    """The session that a field names: PLACE/NAME."""
    place, _, called = given.partition("/")
    return sessions.find(places_of(request), number(place), called)


def one(fields: Form) -> dict[str, str]:
    return {name: values[-1] for name, values in fields.items()}


def number(place: str) -> int:
    """Of a chosen folder; -1, which is none, for what is no number of one."""
    return int(place) if place.isdecimal() and len(place) < 10 else -1


def to(session: Session, step: str) -> Response:
    return RedirectResponse(f"/s/{session.place}/{quote(session.name)}/{step}", 303)


def served(path: Path, is_saved: bool) -> Response:
    """A file that a command wrote; a page among them in a sandbox of its own."""
    if not path.is_file():
        raise HTTPException(404, "no such file")
    kind = SHOWN.get(path.suffix)
    headers = {"Content-Security-Policy": SANDBOX, "Cross-Origin-Opener-Policy": "unsafe-none"}
    if kind is None or is_saved:
        return FileResponse(path, filename=path.name, media_type="application/octet-stream", headers=headers)
    return FileResponse(path, media_type=kind, headers=headers)

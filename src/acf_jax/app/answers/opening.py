"""Step 1, Open: sessions, uploads, and recordings that are opened in place."""

from pathlib import Path

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from acf_jax.app import sessions, uploads
from acf_jax.app.answers.requests import Form, number, one, places_of, session_named, session_of, to
from acf_jax.app.pages import home
from acf_jax.app.pages import opening as page
from acf_jax.app.sessions import Session
from acf_jax.errors import InputError


def all_sessions(request: Request) -> Response:
    return home.home(places_of(request))


def browse(request: Request) -> Response:
    place, path = number(request.path_params["place"]), request.path_params["path"]
    return home.browse(places_of(request), place, path, request.query_params.get("session", ""))


async def upload(request: Request) -> Response:
    """One file of a recording: ?name=FILE, and ?session=PLACE/NAME for those behind the first.

    ?folder=NAME: of the folder that holds it; the session is called like it.
    """
    asked = request.query_params
    name, given = uploads.file_name(asked.get("name", "")), asked.get("session", "")
    called = asked.get("folder") or Path(name).stem
    session = await run_in_threadpool(_given_or_new, request, given, called)
    target = session.folder / sessions.UPLOADED / name
    try:
        await uploads.receive(request.stream(), target)
    except BaseException:  # a browser that goes away among them
        if not given:
            sessions.remove(session)
        raise
    await run_in_threadpool(_take_uploaded, session)
    return JSONResponse({"session": f"{session.place}/{session.name}", "next": f"{session.url}/open"})


def _given_or_new(request: Request, given: str, called: str) -> Session:
    return session_named(request, given) if given else sessions.create(places_of(request), called)


def _take_uploaded(session: Session) -> None:
    """The recording is the one file that was uploaded, or the folder of a bag."""
    folder = session.folder / sessions.UPLOADED
    names = sorted(path.name for path in folder.iterdir() if path.name[0] != ".")
    is_bag = "metadata.yaml" in names
    recording = sessions.UPLOADED if is_bag or len(names) != 1 else f"{sessions.UPLOADED}/{names[0]}"
    if not is_bag and len(names) == 2:  # the robot's signals in a recording of their own
        first = session.about.recording or f"{sessions.UPLOADED}/{names[0]}"
        other = next(
            f"{sessions.UPLOADED}/{name}" for name in names if f"{sessions.UPLOADED}/{name}" != first
        )
        session.describe(session.about.model_copy(update={"recording": first, "robot": other}))
        return
    session.describe(session.about.model_copy(update={"recording": recording}))


def new_session(request: Request, fields: Form) -> Response:
    return to(sessions.create(places_of(request), one(fields).get("name", "")), "rig")


def open_recording(request: Request, fields: Form) -> Response:
    """A recording, or a data set, on this machine; into a session as the robot's recording where one is named."""
    given = one(fields)
    path = places_of(request).resolve(number(given.get("place", "")), given.get("path", ""))
    if given.get("session"):
        session = session_named(request, given["session"])
        session.describe(session.about.model_copy(update={"robot": str(path)}))
        return to(session, "open")
    session = sessions.create(places_of(request), path.stem if path.is_file() else path.name)
    try:
        sessions.open_in_place(session, path)
    except InputError:
        sessions.remove(session)
        raise
    return to(session, "open" if session.about.recording else "diagnose")


def preview(request: Request) -> Response:
    asked = request.query_params
    session = session_of(request)
    found = page.preview(session, asked.get("which", ""), asked.get("name", ""), asked.get("field", ""))
    return JSONResponse(found, 400 if found["faults"] else 200)


def without_robot(request: Request, fields: Form) -> Response:
    session = session_of(request)
    session.describe(session.about.model_copy(update={"robot": None}))
    return to(session, "open")

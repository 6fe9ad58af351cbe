"""The addresses of the app, each a thin way from a request to the library and back."""

import asyncio
import json
import secrets
from collections.abc import AsyncIterator, Awaitable, Callable
from functools import cache, wraps
from importlib.resources import files
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, quote

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, RedirectResponse, Response, StreamingResponse
from starlette.routing import Route

from acf_jax.app import commands, fleets, jobs, printing, sessions, signals, uploads
from acf_jax.app.pages import cutting, diagnosing, home, opening, planning, rig, using
from acf_jax.app.pages import fleet as fleet_page
from acf_jax.app.pages.layout import faults_box, page
from acf_jax.app.security import SANDBOX, Guard, Places
from acf_jax.app.sessions import CUTS, DATA, DIAGNOSIS, MAPPING, RIG, Session
from acf_jax.documents import parse_json
from acf_jax.errors import InputError
from acf_jax.files import inside, write_bytes, write_text

LARGEST_FORM = 4_000_000  # bytes
WATCHED_S = 0.25  # between two looks at a job
SHOWN = {".html": "text/html; charset=utf-8"}  # files that a browser shows; all others it only saves
REACHED = (DATA, DIAGNOSIS, sessions.SURROGATE)  # folders of a session whose files can be had

Form = dict[str, list[str]]


def make_app(folders: list[Path], token: str, port: int) -> Starlette:
    """The application: it reads and writes in `folders` alone, and answers who has the token."""
    real = [folder.resolve() for folder in folders]
    app = Starlette(
        routes=_routes(),
        middleware=[Middleware(Guard, token=token, port=port)],
        exception_handlers={InputError: _faulty, HTTPException: _missing, OSError: _unreadable},
    )
    app.state.places = Places(real)
    return app


def new_token() -> str:
    """One that nobody guesses."""
    return secrets.token_urlsafe(24)


def _routes() -> list[Route]:
    steps = {
        "open": opening.opening, "cut": cutting.cutting, "rig": rig.rig, "plan": planning.planning,
        "diagnose": diagnosing.diagnosing, "use": using.using,
    }  # fmt: skip
    of_session: dict[str, Callable[[Request], Response]] = {
        **{step: _show(shown) for step, shown in steps.items()},
        "preview": _preview, "curve": _curve, "file/{path:path}": _file, "report.pdf": _pdf, "script.{kind}": _script,
    }  # fmt: skip
    changes: dict[str, Callable[[Request, Form], Response]] = {
        "signals": _signals, "rescale": _rescale, "without-robot": _without_robot, "cuts": _cuts,
        "forget-cuts": _forget_cuts, "rig": _rig, "plan": _plan, "diagnose": _diagnose, "train": _train,
        "export": _export, "ask/{question}": _ask, "cancel": _cancel,
    }  # fmt: skip
    at = "/s/{place:int}/{name}"
    return [
        _get("/", lambda request: home.home(_places(request))),
        Route("/static/{file}", _static, methods=["GET"]),
        _get("/browse/{place:int}/{path:path}", _browse),
        Route("/upload", _upload, methods=["PUT"]),
        _post("/new", _new),
        _post("/open", _open),
        _get("/fleet", lambda r: fleet_page.fleet(_places(r), r.query_params.get("shown", ""))),
        _post("/fleet", _compare),
        _get("/fleet/{label}/{path:path}", _fleet_file),
        Route(f"{at}/events", _events, methods=["GET"]),
        *(_get(f"{at}/{name}", answer) for name, answer in of_session.items()),
        *(_post(f"{at}/{name}", answer) for name, answer in changes.items()),
    ]


def _get(path: str, answer: Callable[[Request], Response]) -> Route:
    return Route(path, _plain(answer), methods=["GET"])


def _post(path: str, answer: Callable[[Request, Form], Response]) -> Route:
    return Route(path, _posted(answer), methods=["POST"])


# How a request reaches a function, and how its faults reach the user.


def _plain(answer: Callable[[Request], Response]) -> Callable[[Request], Awaitable[Response]]:
    """In a thread: reading files must not hold up other answers."""

    @wraps(answer)
    async def endpoint(request: Request) -> Response:
        return await run_in_threadpool(answer, request)

    return endpoint


def _posted(answer: Callable[[Request, Form], Response]) -> Callable[[Request], Awaitable[Response]]:
    """The same with the fields of a form, or those of a JSON object."""

    @wraps(answer)
    async def endpoint(request: Request) -> Response:
        content = bytearray()
        async for piece in request.stream():
            content += piece
            if len(content) > LARGEST_FORM:
                raise HTTPException(413, "the form is too large")
        try:
            text = content.decode()
        except UnicodeDecodeError:
            raise HTTPException(400, "the form is no text") from None
        if request.headers.get("content-type", "").startswith("application/json"):
            request.state.json = parse_json(text, "the request", "load the page again")
            fields: Form = {}
        else:
            try:
                fields = parse_qs(text, keep_blank_values=True, max_num_fields=2000)
            except ValueError:
                raise HTTPException(400, "the form has too many fields") from None
        return await run_in_threadpool(answer, request, fields)

    return endpoint


def _show(shown: Callable[[Session], Response]) -> Callable[[Request], Response]:
    return lambda request: shown(_session(request))


def _places(request: Request) -> Places:
    places: Places = request.app.state.places
    return places


def _session(request: Request) -> Session:
    return sessions.find(_places(request), int(request.path_params["place"]), request.path_params["name"])


def _one(fields: Form) -> dict[str, str]:
    return {name: values[-1] for name, values in fields.items()}


def _to(session: Session, step: str) -> Response:
    return RedirectResponse(f"/s/{session.place}/{quote(session.name)}/{step}", 303)


async def _faulty(request: Request, error: Exception) -> Response:
    assert isinstance(error, InputError)
    status = 409 if isinstance(error, sessions.Changed) else 400
    if _wants_json(request):
        return JSONResponse({"faults": error.faults}, status)
    return page("That did not work", faults_box(error.faults, "What is wrong"), status=status)


async def _missing(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    if _wants_json(request):
        return JSONResponse({"faults": [error.detail]}, error.status_code)
    return page("Not here", faults_box([error.detail], "What is wrong"), status=error.status_code)


async def _unreadable(request: Request, error: Exception) -> Response:
    assert isinstance(error, OSError)
    what = f"{error.filename or 'a file'}: {error.strerror or error}; check path, permissions and disk"
    return await _faulty(request, InputError(what))


def _wants_json(request: Request) -> bool:
    return "application/json" in request.headers.get("accept", "")


# Files that come with the app.


@cache
def _static_file(name: str) -> tuple[bytes, str] | None:
    from plotly.offline import get_plotlyjs

    kinds = {"css": "text/css", "js": "text/javascript", "svg": "image/svg+xml"}
    if name == "plotly.js":
        return get_plotlyjs().encode(), kinds["js"]
    package = "acf_jax.report" if name in ("page.css", "page.js") else "acf_jax.app"
    folder = files(package) if package == "acf_jax.report" else files(package) / "static"
    known = {item.name for item in folder.iterdir()}
    kind = kinds.get(name.rpartition(".")[2])
    return ((folder / name).read_bytes(), kind) if name in known and kind else None


async def _static(request: Request) -> Response:
    found = _static_file(request.path_params["file"])
    if found is None:
        raise HTTPException(404, "no such file")
    return Response(found[0], media_type=found[1], headers={"Cache-Control": "private, max-age=600"})


# 1 Open


def _browse(request: Request) -> Response:
    place, path = int(request.path_params["place"]), request.path_params["path"]
    return home.browse(_places(request), place, path, request.query_params.get("session", ""))


async def _upload(request: Request) -> Response:
    """One file of a recording: ?name=FILE, and ?session=PLACE/NAME for those behind the first."""
    name = uploads.file_name(request.query_params.get("name", ""))
    given = request.query_params.get("session", "")
    session = await run_in_threadpool(_given_or_new, request, given, name)
    target = session.folder / sessions.UPLOADED / name
    try:
        await uploads.receive(request.stream(), target)
    except BaseException:  # a browser that goes away among them
        if not given:
            sessions.remove(session)
        raise
    await run_in_threadpool(_take_uploaded, session)
    return JSONResponse({"session": f"{session.place}/{session.name}", "next": f"{session.url}/open"})


def _given_or_new(request: Request, given: str, name: str) -> Session:
    if given:
        place, _, called = given.partition("/")
        return sessions.find(_places(request), int(place) if place.isdecimal() else -1, called)
    return sessions.create(_places(request), Path(name).stem)


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


def _new(request: Request, fields: Form) -> Response:
    return _to(sessions.create(_places(request), _one(fields).get("name", "")), "rig")


def _open(request: Request, fields: Form) -> Response:
    """A recording, or a data set, on this machine; into a session as the robot's recording where one is named."""
    given = _one(fields)
    place = given.get("place", "")
    path = _places(request).resolve(int(place) if place.isdecimal() else -1, given.get("path", ""))
    if given.get("session"):
        session = _given_or_new(request, given["session"], "")
        session.describe(session.about.model_copy(update={"robot": str(path)}))
        return _to(session, "open")
    session = sessions.create(_places(request), path.stem if path.is_file() else path.name)
    try:
        sessions.open_in_place(session, path)
    except InputError:
        sessions.remove(session)
        raise
    return _to(session, "open" if session.about.recording else "diagnose")


def _preview(request: Request) -> Response:
    asked = request.query_params
    session = _session(request)
    found = opening.preview(session, asked.get("which", ""), asked.get("name", ""), asked.get("field", ""))
    return JSONResponse(found, 400 if found["faults"] else 200)


def _signals(request: Request, fields: Form) -> Response:
    session, given = _session(request), _one(fields)
    content = signals.mapped(signals.read(session.folder / MAPPING), given)
    return _cut_anew(session, content, given.get("version", ""))


def _rescale(request: Request, fields: Form) -> Response:
    session, given = _session(request), _one(fields)
    try:
        factor = float(given.get("factor", ""))
    except ValueError:
        raise InputError("the factor is no number; choose the signal's sign and unit by hand") from None
    role = given.get("role", "")
    if role not in signals.ROLES:
        raise InputError("no such signal; choose its sign and unit by hand")
    content = signals.rescaled(signals.read(session.folder / MAPPING), opening.offers(session), role, factor)
    return _cut_anew(session, content, given.get("version", ""))


def _cut_anew(session: Session, content: dict[str, Any], version: str) -> Response:
    session.write(MAPPING, signals.text_of(content), version)
    jobs.start(session.folder, "import", commands.import_command(session))
    return _to(session, "cut")


def _without_robot(request: Request, fields: Form) -> Response:
    session = _session(request)
    session.describe(session.about.model_copy(update={"robot": None}))
    return _to(session, "open")


# 2 Cut


def _cuts(request: Request, fields: Form) -> Response:
    session = _session(request)
    content = getattr(request.state, "json", None)
    sent = content if isinstance(content, dict) else {}
    session.write(CUTS, cutting.review_of(session, sent.get("cuts")), str(sent.get("version", "")))
    jobs.start(session.folder, "import", commands.import_command(session))
    return JSONResponse({"next": f"{session.url}/cut"})


def _forget_cuts(request: Request, fields: Form) -> Response:
    session = _session(request)
    with session.writing(CUTS, _one(fields).get("version", "")):
        (session.folder / CUTS).unlink(missing_ok=True)
    jobs.start(session.folder, "import", commands.import_command(session))
    return _to(session, "cut")


# 3 Rig


def _rig(request: Request, fields: Form) -> Response:
    session, given = _session(request), _one(fields)
    try:
        text = rig.rig_text(session, given)
    except InputError as error:
        return rig.rig(session, error.faults, given)
    session.write(RIG, text, given.get("version", ""))
    if session.recording() is not None and session.is_imported:
        jobs.start(session.folder, "import", commands.import_command(session))
        return _to(session, "cut")
    if session.is_imported:
        write_text(session.folder / DATA / "dataset.yaml", rig.description_with(session, text))
        return _to(session, "diagnose")
    return _to(session, "plan" if session.recording() is None else "open")


# 4 Plan


def _plan(request: Request, fields: Form) -> Response:
    session, given = _session(request), _one(fields)
    try:
        text, values = planning.trials(given)
        if given.get("of") == "trials":
            text = (session.folder / DATA / "trials.csv").read_text("utf-8")
        description = planning.description(session)
    except (InputError, OSError) as error:
        faults = (
            error.faults if isinstance(error, InputError) else ["the session's trials.csv cannot be read"]
        )
        return planning.planning(session, faults, given)
    write_text(session.folder / commands.DESCRIPTION, description)
    write_text(session.folder / commands.CONDITIONS, text)
    write_text(session.folder / commands.SLIDERS, json.dumps(values))
    jobs.start(session.folder, "plan", commands.plan_command(values["rate"], values["noise"]))
    return _to(session, "plan")


# 5 Diagnose


def _diagnose(request: Request, fields: Form) -> Response:
    session = _session(request)
    may_be = set(fields.get("cause", []))
    without = [name for name in diagnosing.effects() if name not in may_be]
    jobs.start(session.folder, "diagnose", commands.diagnose_command(without))
    return _to(session, "diagnose")


def _cancel(request: Request, fields: Form) -> Response:
    session = _session(request)
    jobs.cancel(session.folder)
    job = jobs.last(session.folder)
    steps = {"import": "cut", "plan": "plan", "diagnose": "diagnose"}
    return _to(session, steps.get(job.kind, "use") if job else "open")


async def _events(request: Request) -> Response:
    """The state of the last job, each time it changes, until it has ended."""
    session = await run_in_threadpool(_session, request)

    async def told() -> AsyncIterator[str]:
        while not await request.is_disconnected():
            job = await run_in_threadpool(jobs.last, session.folder)
            if job is None:
                return
            yield f"data: {json.dumps(job.document())}\n\n"
            if not job.is_running:
                return
            await asyncio.sleep(WATCHED_S)

    return StreamingResponse(told(), media_type="text/event-stream")


# 6 Use


def _curve(request: Request) -> Response:
    from acf_jax.app import live

    model = using.model_of(_session(request))
    return JSONResponse(live.curve(model, live.asked_of(dict(request.query_params), model)))


def _ask(request: Request, fields: Form) -> Response:
    return JSONResponse(using.answer(_session(request), request.path_params["question"], _one(fields)))


def _train(request: Request, fields: Form) -> Response:
    session = _session(request)
    jobs.start(session.folder, "train", commands.train_command())
    return _to(session, "use")


def _export(request: Request, fields: Form) -> Response:
    session = _session(request)
    jobs.start(session.folder, "export", commands.export_command())
    return _to(session, "use")


def _file(request: Request) -> Response:
    session, path = _session(request), request.path_params["path"]
    top, _, rest = path.partition("/")
    if top not in REACHED:
        raise HTTPException(404, "no such file in this session")
    found = _places(request).check(inside(session.folder / top, rest))
    return _served(found, "download" in request.query_params)


def _served(path: Path, is_saved: bool) -> Response:
    """A file that a command wrote; a page among them in a sandbox of its own."""
    if not path.is_file():
        raise HTTPException(404, "no such file")
    kind = SHOWN.get(path.suffix)
    headers = {"Content-Security-Policy": SANDBOX, "Cross-Origin-Opener-Policy": "unsafe-none"}
    if kind is None or is_saved:
        return FileResponse(path, filename=path.name, media_type="application/octet-stream", headers=headers)
    return FileResponse(path, media_type=kind, headers=headers)


def _pdf(request: Request) -> Response:
    session = _session(request)
    report, pdf = session.folder / DIAGNOSIS / "report.html", session.folder / DIAGNOSIS / "report.pdf"
    if not report.is_file():
        raise HTTPException(404, "there is no report yet; diagnose first")
    if not pdf.is_file() or pdf.stat().st_mtime < report.stat().st_mtime:
        write_bytes(pdf, printing.pdf_of(report))
    return FileResponse(pdf, filename="report.pdf", media_type="application/pdf")


def _script(request: Request) -> Response:
    session, kind = _session(request), request.path_params["kind"]
    if kind == "sh":
        done = [jobs.job(session.folder, kind) for kind in jobs.KINDS]
        text = commands.shell_script(session, [job.command for job in done if job and job.state == "done"])
    elif kind == "py":
        text = commands.python_script(session, diagnosing.without_of(session), using.question_of(session))
    else:
        raise HTTPException(404, "no such script")
    headers = {"Content-Disposition": f'attachment; filename="session.{kind}"'}
    return Response(text, media_type="text/plain; charset=utf-8", headers=headers)


# 7 Fleet


def _compare(request: Request, fields: Form) -> Response:
    places = _places(request)
    try:
        chosen = [_given_or_new(request, given, "") for given in fields.get("session", []) if given]
        label = fleets.compare(places.folders[0], chosen, fields.get("since", []))
    except InputError as error:
        return fleet_page.fleet(places, faults=error.faults)
    return RedirectResponse(f"/fleet?shown={quote(label)}", 303)


def _fleet_file(request: Request) -> Response:
    label, path = request.path_params["label"], request.path_params["path"]
    if label not in fleets.earlier(_places(request).folders[0]):
        raise HTTPException(404, "no such comparison")
    return _served(_places(request).resolve(0, f"{fleets.FOLDER}/{label}/{path}"), False)

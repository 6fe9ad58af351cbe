"""What each address does: from a request to the library or a command, and back."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import quote

from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, RedirectResponse, Response, StreamingResponse

from acf_jax.app import commands, fleets, jobs, printing, sessions, signals, uploads
from acf_jax.app.pages import cutting, diagnosing, home, opening, planning, rig, using
from acf_jax.app.pages import fleet as fleet_page
from acf_jax.app.security import SANDBOX, Places
from acf_jax.app.sessions import CUTS, DATA, DIAGNOSIS, MAPPING, RIG, Session
from acf_jax.errors import InputError
from acf_jax.files import inside, write_bytes, write_text

WATCHED_S = 0.25  # between two looks at a job
SHOWN = {".html": "text/html; charset=utf-8"}  # files that a browser shows; all others it only saves
REACHED = (DATA, DIAGNOSIS, sessions.SURROGATE)  # folders of a session whose files can be had

Form = dict[str, list[str]]


def show(shown: Callable[[Session], Response]) -> Callable[[Request], Response]:
    return lambda request: shown(session_of(request))


def places_of(request: Request) -> Places:
    places: Places = request.app.state.places
    return places


def session_of(request: Request) -> Session:
    return sessions.find(
        places_of(request), _number(request.path_params["place"]), request.path_params["name"]
    )


def one(fields: Form) -> dict[str, str]:
    return {name: values[-1] for name, values in fields.items()}


def _number(place: str) -> int:
    """Of a chosen folder; -1, which is none, for what is no number of one."""
    return int(place) if place.isdecimal() and len(place) < 10 else -1


def to(session: Session, step: str) -> Response:
    return RedirectResponse(f"/s/{session.place}/{quote(session.name)}/{step}", 303)


# 1 Open


def all_sessions(request: Request) -> Response:
    return home.home(places_of(request))


def browse(request: Request) -> Response:
    place, path = _number(request.path_params["place"]), request.path_params["path"]
    return home.browse(places_of(request), place, path, request.query_params.get("session", ""))


async def upload(request: Request) -> Response:
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
        return sessions.find(places_of(request), _number(place), called)
    return sessions.create(places_of(request), Path(name).stem)


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
    path = places_of(request).resolve(_number(given.get("place", "")), given.get("path", ""))
    if given.get("session"):
        session = _given_or_new(request, given["session"], "")
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
    found = opening.preview(session, asked.get("which", ""), asked.get("name", ""), asked.get("field", ""))
    return JSONResponse(found, 400 if found["faults"] else 200)


def save_signals(request: Request, fields: Form) -> Response:
    session, given = session_of(request), one(fields)
    content = signals.mapped(signals.read(session.folder / MAPPING), given)
    return _cut_anew(session, content, given.get("version", ""))


def rescale(request: Request, fields: Form) -> Response:
    session, given = session_of(request), one(fields)
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
    _import(session, lambda: session.write(MAPPING, signals.text_of(content), version))
    return to(session, "cut")


def _import(session: Session, change: Callable[[], None]) -> None:
    """Change one of its files and cut anew: both, or where a job runs or there is no recording, none."""
    commands.import_command(session)

    def changed() -> list[str]:
        change()
        return commands.import_command(session)

    jobs.start(session.folder, "import", changed)


def without_robot(request: Request, fields: Form) -> Response:
    session = session_of(request)
    session.describe(session.about.model_copy(update={"robot": None}))
    return to(session, "open")


# 2 Cut


def save_cuts(request: Request, fields: Form) -> Response:
    session = session_of(request)
    content = getattr(request.state, "json", None)
    sent = content if isinstance(content, dict) else {}
    text = cutting.review_of(session, sent.get("cuts"))
    _import(session, lambda: session.write(CUTS, text, str(sent.get("version", ""))))
    return JSONResponse({"next": f"{session.url}/cut"})


def forget_cuts(request: Request, fields: Form) -> Response:
    session = session_of(request)

    def forget() -> None:
        with session.writing(CUTS, one(fields).get("version", "")):
            (session.folder / CUTS).unlink(missing_ok=True)

    _import(session, forget)
    return to(session, "cut")


# 3 Rig


def save_rig(request: Request, fields: Form) -> Response:
    session, given = session_of(request), one(fields)
    try:
        text = rig.rig_text(session, given)
    except InputError as error:
        return rig.rig(session, error.faults, given)
    write = partial(session.write, RIG, text, given.get("version", ""))
    if session.recording() is not None and session.is_imported:
        _import(session, write)
        return to(session, "cut")
    write()
    if session.is_imported:
        write_text(session.folder / DATA / "dataset.yaml", rig.description_with(session, text))
        return to(session, "diagnose")
    return to(session, "plan" if session.recording() is None else "open")


# 4 Plan


def start_plan(request: Request, fields: Form) -> Response:
    session, given = session_of(request), one(fields)
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

    def planned() -> list[str]:
        write_text(session.folder / commands.DESCRIPTION, description)
        write_text(session.folder / commands.CONDITIONS, text)
        write_text(session.folder / commands.SLIDERS, json.dumps(values))
        return commands.plan_command(values["rate"], values["noise"])

    jobs.start(session.folder, "plan", planned)
    return to(session, "plan")


# 5 Diagnose


def start_diagnosis(request: Request, fields: Form) -> Response:
    session = session_of(request)
    may_be = set(fields.get("cause", []))
    without = [name for name in diagnosing.effects() if name not in may_be]
    jobs.start(session.folder, "diagnose", commands.diagnose_command(without))
    return to(session, "diagnose")


def cancel(request: Request, fields: Form) -> Response:
    session = session_of(request)
    jobs.cancel(session.folder)
    job = jobs.last(session.folder)
    steps = {"import": "cut", "plan": "plan", "diagnose": "diagnose"}
    return to(session, steps.get(job.kind, "use") if job else "open")


async def events(request: Request) -> Response:
    """The state of the last job, each time it changes, until it has ended."""
    session = await run_in_threadpool(session_of, request)

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


def curve(request: Request) -> Response:
    from acf_jax.app import live

    model = using.model_of(session_of(request))
    return JSONResponse(live.curve(model, live.asked_of(dict(request.query_params), model)))


def ask(request: Request, fields: Form) -> Response:
    return JSONResponse(using.answer(session_of(request), request.path_params["question"], one(fields)))


def start_training(request: Request, fields: Form) -> Response:
    session = session_of(request)
    jobs.start(session.folder, "train", commands.train_command())
    return to(session, "use")


def start_export(request: Request, fields: Form) -> Response:
    session = session_of(request)
    jobs.start(session.folder, "export", commands.export_command())
    return to(session, "use")


def file_of(request: Request) -> Response:
    session, path = session_of(request), request.path_params["path"]
    top, _, rest = path.partition("/")
    if top not in REACHED:
        raise HTTPException(404, "no such file in this session")
    found = places_of(request).check(inside(session.folder / top, rest))
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


def pdf(request: Request) -> Response:
    session = session_of(request)
    report, pdf = session.folder / DIAGNOSIS / "report.html", session.folder / DIAGNOSIS / "report.pdf"
    if not report.is_file():
        raise HTTPException(404, "there is no report yet; diagnose first")
    if not pdf.is_file() or pdf.stat().st_mtime < report.stat().st_mtime:
        write_bytes(pdf, printing.pdf_of(report))
    return FileResponse(pdf, filename="report.pdf", media_type="application/pdf")


def script(request: Request) -> Response:
    session, kind = session_of(request), request.path_params["kind"]
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


def fleet(request: Request) -> Response:
    return fleet_page.fleet(places_of(request), request.query_params.get("shown", ""))


def compare_fleet(request: Request, fields: Form) -> Response:
    places = places_of(request)
    places.check(places.folders[0] / fleets.FOLDER)
    try:
        chosen = [_given_or_new(request, given, "") for given in fields.get("session", []) if given]
        label = fleets.compare(places.folders[0], chosen, fields.get("since", []))
    except InputError as error:
        return fleet_page.fleet(places, faults=error.faults)
    return RedirectResponse(f"/fleet?shown={quote(label)}", 303)


def fleet_file(request: Request) -> Response:
    label, path = request.path_params["label"], request.path_params["path"]
    if label not in fleets.earlier(places_of(request).folders[0]):
        raise HTTPException(404, "no such comparison")
    return _served(places_of(request).resolve(0, f"{fleets.FOLDER}/{label}/{path}"), False)

"""Steps 6 and 7: questions to a model, what is taken away, and comparisons."""

from urllib.parse import quote

from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, RedirectResponse, Response

from acf_jax.app import commands, fleets, jobs, printing, scripts, sessions
from acf_jax.app.answers.requests import Form, one, places_of, served, session_named, session_of, to
from acf_jax.app.pages import fleet as fleet_page
from acf_jax.app.pages import using
from acf_jax.app.sessions import DATA, DIAGNOSIS
from acf_jax.errors import InputError
from acf_jax.files import inside

REACHED = (DATA, DIAGNOSIS, sessions.SURROGATE)  # folders of a session whose files can be had


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
    return served(found, "download" in request.query_params)


def pdf(request: Request) -> Response:
    report = session_of(request).folder / DIAGNOSIS / "report.html"
    if not report.is_file():
        raise HTTPException(404, "there is no report yet; diagnose first")
    headers = {"Content-Disposition": 'attachment; filename="report.pdf"'}
    return Response(printing.pdf_of(report), media_type="application/pdf", headers=headers)


def script(request: Request) -> Response:
    session, kind = session_of(request), request.path_params["kind"]
    written = {"sh": scripts.shell_script, "py": scripts.python_script}.get(kind)
    if written is None:
        raise HTTPException(404, "no such script")
    text = written(session)
    headers = {"Content-Disposition": f'attachment; filename="session.{kind}"'}
    return Response(text, media_type="text/plain; charset=utf-8", headers=headers)


# 7 Fleet


def fleet(request: Request) -> Response:
    return fleet_page.fleet(places_of(request), request.query_params.get("shown", ""))


def compare_fleet(request: Request, fields: Form) -> Response:
    places = places_of(request)
    places.check(places.folders[0] / fleets.FOLDER)
    try:
        chosen = [session_named(request, given) for given in fields.get("session", []) if given]
        label = fleets.compare(places.folders[0], chosen, fields.get("since", []))
    except InputError as error:
        return fleet_page.fleet(places, faults=error.faults)
    return RedirectResponse(f"/fleet?shown={quote(label)}", 303)


def fleet_file(request: Request) -> Response:
    label, path = request.path_params["label"], request.path_params["path"]
    if label not in fleets.earlier(places_of(request).folders[0]):
        raise HTTPException(404, "no such comparison")
    return served(places_of(request).resolve(0, f"{fleets.FOLDER}/{label}/{path}"), False)

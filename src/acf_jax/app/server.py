"""The app: its addresses, how requests reach a function, and how faults reach the user."""

import secrets
from collections.abc import Awaitable, Callable
from functools import cache, wraps
from importlib.resources import files
from pathlib import Path
from urllib.parse import parse_qs

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from acf_jax.app import sessions
from acf_jax.app.answers import opening as recordings
from acf_jax.app.answers import steps as session_steps
from acf_jax.app.answers import using as models
from acf_jax.app.answers.requests import Form, show
from acf_jax.app.pages import cutting, diagnosing, opening, planning, rig, using
from acf_jax.app.pages.layout import faults_box, page
from acf_jax.app.security import Guard, Places
from acf_jax.documents import parse_json
from acf_jax.errors import InputError
from acf_jax.style import stylesheet

LARGEST_FORM = 4_000_000  # bytes


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
        **{step: show(shown) for step, shown in steps.items()},
        "preview": recordings.preview,
        "curve": models.curve,
        "file/{path:path}": models.file_of,
        "report.pdf": models.pdf,
        "script.{kind}": models.script,
    }
    changes: dict[str, Callable[[Request, Form], Response]] = {
        "signals": session_steps.save_signals,
        "rescale": session_steps.rescale,
        "without-robot": recordings.without_robot,
        "cuts": session_steps.save_cuts,
        "forget-cuts": session_steps.forget_cuts,
        "rig": session_steps.save_rig,
        "plan": session_steps.start_plan,
        "diagnose": session_steps.start_diagnosis,
        "train": models.start_training,
        "export": models.start_export,
        "ask/{question}": models.ask,
        "cancel": session_steps.cancel,
    }
    at = "/s/{place}/{name}"
    return [
        _get("/", recordings.all_sessions),
        Route("/static/{file}", _static, methods=["GET"]),
        _get("/browse/{place}/{path:path}", recordings.browse),
        Route("/upload", recordings.upload, methods=["PUT"]),
        _post("/new", recordings.new_session),
        _post("/open", recordings.open_recording),
        _get("/fleet", models.fleet),
        _post("/fleet", models.compare_fleet),
        _get("/fleet/{label}/{path:path}", models.fleet_file),
        Route(f"{at}/events", session_steps.events, methods=["GET"]),
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
    if name == "style.css":
        return stylesheet().encode(), kinds["css"]
    folder = files("acf_jax.report") if name == "page.js" else files("acf_jax.app") / "static"
    known = {item.name for item in folder.iterdir()}
    kind = kinds.get(name.rpartition(".")[2])
    return ((folder / name).read_bytes(), kind) if name in known and kind else None


async def _static(request: Request) -> Response:
    found = _static_file(request.path_params["file"])
    if found is None:
        raise HTTPException(404, "no such file")
    return Response(found[0], media_type=found[1], headers={"Cache-Control": "private, max-age=600"})

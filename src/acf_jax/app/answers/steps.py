"""Steps 1 to 5: what a form or a page changes in a session, and the command that follows."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from functools import partial
from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response, StreamingResponse

from acf_jax.app import commands, jobs, signals
from acf_jax.app.answers.requests import Form, one, session_of, to
from acf_jax.app.pages import cutting, opening, planning, rig
from acf_jax.app.sessions import CUTS, DATA, MAPPING, RIG, Session
from acf_jax.errors import InputError
from acf_jax.files import write_text

WATCHED_S = 0.25  # between two looks at a job


# 1 Open


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
    from acf_jax.effects import library

    session = session_of(request)
    may_be = set(fields.get("cause", []))
    without = [name for name in library() if name not in may_be]
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

"""Scripts that repeat every step of a session, as commands and in Python; they run in the session's folder."""

import shlex
from typing import Any

from acf_jax.app import commands
from acf_jax.app.commands import HEADER, LEARNT, MODEL, ONNX
from acf_jax.app.current import diagnosed_by
from acf_jax.app.questions import COMMANDS, asked
from acf_jax.app.sessions import CUTS, DATA, DIAGNOSIS, MAPPING, RIG, SURROGATE, Session

ABOUT = "Repeats the session. Run it in the session's folder, which holds the files that it names."


def shell_script(session: Session) -> str:
    """The commands."""
    has_recording = session.recording() is not None and session.is_imported
    has_net = commands.model_file(session) == LEARNT
    steps = [
        commands.import_command(session) if has_recording else None,
        commands.planned(session),
        commands.diagnosed(session),
        commands.train_command() if has_net else None,
        commands.export_command() if has_net and session.has(HEADER) else None,
    ]
    lines = [_line(step) for step in steps if step]
    if session.is_diagnosed:
        model = commands.model_file(session)
        questions = [_line(COMMANDS[name](call, model)) for name, call in asked(session).items()]
        # a `no` ends with 1, and is an answer
        lines += [f"{line} || [ $? -eq 1 ]" for line in questions]
    return "\n".join(["#!/bin/sh", f"# {ABOUT}", "set -e", *lines, ""])


def python_script(session: Session) -> str:
    """The same in Python; what only a command does is asked of the command."""
    lines = [f'"""{ABOUT}"""', "", "import acf_jax as acf", ""]
    has_net, plan = commands.model_file(session) == LEARNT, commands.planned(session)
    has_export = has_net and session.has(HEADER)
    if plan or has_export:
        lines[2:3] = ["import acf_jax as acf", "from acf_jax.cli.main import commands"]
    recording, robot = session.recording(), session.recording("robot")
    if recording is not None and session.is_imported:
        files = (("mapping", MAPPING), ("rig", RIG), ("review", CUTS))
        given = {key: name for key, name in files if session.has(name)}
        given |= {"robot": str(robot)} if robot else {}
        lines.append(f"data = acf.read_recording({_arguments({'': str(recording)} | given)})")
    elif session.is_imported:
        lines.append(f"data = acf.read_dataset({DATA!r})")
    if plan:
        lines.append(_asked_of_command(plan))
    if commands.diagnosed(session):
        without, low_pass = diagnosed_by(session)
        options = {"without": without} if without else {}
        lines.append(
            f"diagnosis = acf.diagnose({_arguments({'': Name('data')} | options | _filter(low_pass))})"
        )
        lines += [f"diagnosis.save({DIAGNOSIS!r})", "print(diagnosis)"]
    if session.is_diagnosed:
        lines.append(
            f"model = acf.train({MODEL!r}, {SURROGATE!r})"
            if has_net
            else f"model = acf.read_model({MODEL!r})"
        )
        if has_export:
            lines.append(_asked_of_command(["export", "--surrogate", LEARNT, "--c", HEADER, "--onnx", ONNX]))
        lines += [f"print(model.{name}({_arguments(call)}))" for name, call in asked(session).items()]
    return "\n".join([*lines, ""])


class Name(str):
    """A name in Python, in place of a text."""

    def __repr__(self) -> str:
        return str(self)


def _filter(low_pass: float | None) -> dict[str, Any]:
    return {"low_pass": low_pass} if low_pass else {}


def _arguments(given: dict[str, Any]) -> str:
    return ", ".join(f"{name}={value!r}" if name else f"{value!r}" for name, value in given.items())


def _asked_of_command(command: list[str]) -> str:
    return f"commands({command!r}, standalone_mode=False)"


def _line(command: list[str]) -> str:
    return shlex.join(["python", "-m", "acf_jax", *command])

"""Jobs of a session: commands in processes of their own, whose state lies on the disk.

A page that is loaded again, a second tab, or a server that was killed and started anew finds a job as it is. A session
has one job at a time: its process holds the session's lock until it ends.
"""

import fcntl
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Literal, get_args

from acf_jax.app.stages import left_after
from acf_jax.app.work import CODE, OUTPUT, PROGRESS
from acf_jax.errors import InputError
from acf_jax.files import MAX_BYTES, write_text
from acf_jax.forms import Part, validated
from acf_jax.progress_lines import ASKED, KNOWN

FOLDER, LOCK, ABOUT = ".app", "lock", "job.json"
Kind = Literal["plan", "import", "diagnose", "train", "export"]
KINDS: tuple[Kind, ...] = get_args(Kind)  # in the order of the steps
State = Literal["running", "done", "failed", "stopped", "interrupted"]
STOPPED = 130  # exit code of a command that Ctrl-C stopped
PATIENCE = 5.0  # s, until a job that was asked to stop is killed
ENDING = 60.0  # s, that a process may take to end once its command is done; a busy machine takes ten and more
TOLD = 200  # lines of messages
TRACEBACK = "Traceback (most recent call last):"


class _About(Part):
    """job.json of a kind."""

    kind: Kind
    command: tuple[str, ...]
    started: float  # s since the epoch
    pid: int | None = None


@dataclass(frozen=True)
class Job:
    """One run of a command, as it is now."""

    kind: Kind
    command: tuple[str, ...]
    state: State
    started: float  # s since the epoch
    ended: float | None
    stages: tuple[tuple[str, float], ...]  # name and s since the start, in order
    done: int  # of the last stage
    total: int
    messages: tuple[str, ...]  # what the command said on standard error
    known: tuple[dict[str, Any], ...]  # what it knew before it was done, see `acf_jax.diagnosis.interim`
    output: Path

    @property
    def is_running(self) -> bool:
        return self.state == "running"

    @property
    def left(self) -> float | None:
        """Time that is left, s, roughly; None where it is not known."""
        elapsed = time.time() - self.started
        return left_after(self.kind, self.stages, elapsed, self.done, self.total) if self.is_running else 0.0

    def document(self) -> dict[str, Any]:
        """For a page that watches it."""
        return {
            "kind": self.kind,
            "state": self.state,
            "stages": [name for name, _ in self.stages],
            "done": self.done,
            "total": self.total,
            "elapsed": (self.ended or time.time()) - self.started,
            "left": self.left,
            "known": len(self.known),
        }


def start(session: Path, kind: Kind, command: Sequence[str] | Callable[[], Sequence[str]]) -> None:
    """Begin a command in the folder of a session.

    **Arguments:** `command`: arguments of `python -m acf_jax`, paths from that folder; or a function that writes what
    the command reads and gives them, called only where no job runs.

    **Raises:** `InputError` where a job runs there already.
    """
    (session / FOLDER).mkdir(exist_ok=True)
    with (session / FOLDER / LOCK).open("a") as lock:
        if not _taken(lock, session):
            raise InputError("a job runs in this session already; wait for it, or cancel it")
        if callable(command):
            command = command()
        folder = session / FOLDER / kind
        folder.mkdir(exist_ok=True)
        for name in (CODE, OUTPUT, PROGRESS):
            (folder / name).unlink(missing_ok=True)
        # -P: the session's folder is no place to import modules from
        program = [sys.executable, "-P", "-m", "acf_jax.app.work", str(folder.resolve()), *command]
        about = {"kind": kind, "command": list(command), "started": time.time()}
        write_text(folder / ABOUT, json.dumps(about | {"pid": None}))
        process = subprocess.Popen(
            program,
            cwd=session,
            env=os.environ | {ASKED: "json"},
            stdin=subprocess.DEVNULL,
            pass_fds=[lock.fileno()],
            start_new_session=True,  # Ctrl-C that ends the server does not end the job
        )
        write_text(folder / ABOUT, json.dumps(about | {"pid": process.pid}))
        write_text(session / FOLDER / ABOUT, json.dumps({"kind": kind}))
    threading.Thread(target=process.wait, daemon=True).start()


def _taken(lock: IO[str], session: Path) -> bool:
    """Whether the lock could be had; a job that has just ended, or who only looks, holds it for a moment longer."""
    end = time.monotonic() + ENDING
    while True:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except OSError:
            running = last(session)
            if (running is not None and running.is_running) or time.monotonic() > end:
                return False
        time.sleep(0.02)


def last(session: Path) -> Job | None:
    """The job that began last in a session."""
    about = _read(session / FOLDER / ABOUT) or {}
    kind = next((kind for kind in KINDS if kind == about.get("kind")), None)
    return None if kind is None else job(session, kind)


def job(session: Path, kind: Kind) -> Job | None:
    """The last job of a kind; None where there was none."""
    folder = session / FOLDER / kind
    about = _about(folder)
    if about is None:
        return None
    is_held = _is_held(session) and (_read(session / FOLDER / ABOUT) or {}).get("kind") == kind
    code, ended = _code(folder)
    state: State = "done" if code == 0 else "stopped" if code == STOPPED else "failed"
    if code is None:
        state = "running" if is_held else "interrupted"
    stages: list[tuple[str, float]] = []
    messages: list[str] = []
    known: list[dict[str, Any]] = []
    done, total = 0, 0
    begun = about.started
    for line in _lines(folder / PROGRESS):
        content = _object(line)
        if isinstance(content.get(KNOWN), dict):
            known.append(content[KNOWN])
            continue
        step = _step(content)
        if step is None:
            messages.append(line)
            continue
        name, done, total, at = step
        if not stages or stages[-1][0] != name:
            stages.append((name, at - begun))
    return Job(
        kind=kind,
        command=about.command,
        state=state,
        started=begun,
        ended=ended,
        stages=tuple(stages),
        done=done,
        total=total,
        messages=tuple(_told(messages)[:TOLD]),
        known=tuple(known),
        output=folder / OUTPUT,
    )


def cancel(session: Path) -> None:
    """Stop the running job as Ctrl-C would; where it does not listen, end it."""
    job = last(session)
    own = _about(session / FOLDER / job.kind) if job and job.is_running else None
    if own is None or own.pid is None:
        return
    pid = own.pid
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGINT)

    def insist() -> None:
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            if not _is_held(session):
                return
            time.sleep(0.05)
        with suppress(ProcessLookupError):
            os.killpg(pid, signal.SIGKILL)

    threading.Thread(target=insist, daemon=True).start()


def _is_held(session: Path) -> bool:
    """Whether a process holds the lock of the session."""
    try:
        with (session / FOLDER / LOCK).open("r") as lock:
            fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
            return False
    except FileNotFoundError:
        return False
    except OSError:
        return True


def _about(folder: Path) -> _About | None:
    """What is known of the job in its folder; None where the file is missing or damaged."""
    try:
        return validated(_About, _read(folder / ABOUT))
    except ValueError:
        return None


def _read(path: Path) -> dict[str, Any] | None:
    try:
        content = json.loads(path.read_text())
    except (OSError, ValueError):
        return None
    return content if isinstance(content, dict) else None


def _code(folder: Path) -> tuple[int | None, float | None]:
    """Exit code and when it came."""
    try:
        return int((folder / CODE).read_text()), (folder / CODE).stat().st_mtime
    except (OSError, ValueError):
        return None, None


def _lines(path: Path) -> list[str]:
    try:
        if path.stat().st_size > MAX_BYTES:
            return []
        return path.read_text("utf-8", "replace").splitlines()
    except OSError:
        return []


def _told(lines: list[str]) -> list[str]:
    """What a command said; of a fault of its own that it did not foresee the last line, with a remedy."""
    if TRACEBACK not in lines:
        return lines
    why = next((line for line in reversed(lines) if line and line[0] != " "), "")
    remedy = "a fault of acf-jax itself: please report it, with .app/ of the session's folder"
    return [*lines[: lines.index(TRACEBACK)], f"error: {why}: {remedy}"]


def _object(line: str) -> dict[str, Any]:
    """What a line of progress says; empty for any other line."""
    try:
        content = json.loads(line) if line.startswith("{") else None
    except ValueError:
        return {}
    return content if isinstance(content, dict) else {}


def _step(content: dict[str, Any]) -> tuple[str, int, int, float] | None:
    """Stage, done, total and time; None where they are not told."""
    try:
        return str(content["stage"]), int(content["done"]), int(content["total"]), float(content["at"])
    except (LookupError, TypeError, ValueError):
        return None

"""The commands that a session's steps run, from what its folder holds; a script of them repeats the session."""

import shlex
from collections.abc import Sequence
from pathlib import Path

from acf_jax.app.sessions import CUTS, DATA, DIAGNOSIS, MAPPING, PLAN, RIG, SURROGATE, Session
from acf_jax.errors import InputError

CONDITIONS, DESCRIPTION, SLIDERS = f"{PLAN}/trials.csv", f"{PLAN}/dataset.yaml", f"{PLAN}/sliders.json"
LEARNT, HEADER, ONNX = f"{SURROGATE}/model.eqx", f"{SURROGATE}/peak.h", f"{SURROGATE}/peak.onnx"


def import_command(session: Session) -> list[str]:
    """`import` with the files that are there."""
    recording, robot = session.recording(), session.recording("robot")
    if recording is None:
        raise InputError("this session has no recording; drop one on the first page")
    command = ["import", str(recording), "--out", DATA]
    for option, name in (("--mapping", MAPPING), ("--review", CUTS), ("--rig", RIG)):
        if session.has(name):
            command += [option, name]
    return command + (["--with", str(robot)] if robot else [])


def diagnose_command(without: Sequence[str] = ()) -> list[str]:
    """`diagnose`, without effects that cannot be the cause."""
    return ["diagnose", DATA, "--out", DIAGNOSIS, *(part for name in without for part in ("--without", name))]


def train_command() -> list[str]:
    """`train` on the diagnosis."""
    return ["train", DIAGNOSIS, "--out", SURROGATE]


def export_command() -> list[str]:
    """`export` of the surrogate, as C and as ONNX."""
    return ["export", "--surrogate", LEARNT, "--c", HEADER, "--onnx", ONNX]


def plan_command(rate: float, noise: float) -> list[str]:
    """`plan` of the trials that are written down."""
    return [
        "plan",
        DESCRIPTION,
        "--conditions",
        CONDITIONS,
        "--sample-rate",
        f"{rate:g}",
        "--noise",
        f"{noise:g}",
        "--json",
    ]


def shell_script(session: Session, ran: Sequence[Sequence[str]]) -> str:
    """The commands that ran, to be run again in the session's folder."""
    lines = [shlex.join(["python", "-m", "acf_jax", *command]) for command in ran]
    head = ["#!/bin/sh", "# Repeats the session. Run it in the session's folder, which holds the files that it names.",
            "set -e"]  # fmt: skip
    return "\n".join([*head, *lines, ""])


def python_script(session: Session, without: Sequence[str], question: dict[str, float] | None) -> str:
    """The same in Python."""
    lines = ['"""Repeats the session. Run it in the session\'s folder, which holds the files that it names."""', "",
             "import acf_jax as acf", ""]  # fmt: skip
    recording, robot = session.recording(), session.recording("robot")
    given = [f", {key}={name!r}" for key, name in (("mapping", MAPPING), ("rig", RIG)) if session.has(name)]
    given += [f", robot={str(robot)!r}"] if robot else []
    if recording is not None and not session.has(CUTS):
        lines.append(f"data = acf.read_recording({str(recording)!r}{''.join(given)})")
    else:  # decisions about cuts are in the data set that `import` wrote
        lines.append(f"data = acf.read_dataset({DATA!r})")
    blamed = f", without={list(without)!r}" if without else ""
    lines += [f"diagnosis = acf.diagnose(data{blamed})", "print(diagnosis)", f"diagnosis.save({DIAGNOSIS!r})"]
    if question:
        lines += [
            f"print(diagnosis.peak(v={question['v_e']:g}, f_p={question['f_p']:g}))",
            f"print(diagnosis.speed(f_p={question['f_p']:g}, limit={question['limit']:g}))",
        ]
    if session.has(*Path(LEARNT).parts):
        lines += [f"net = diagnosis.train({SURROGATE!r})", f"net.export_c({HEADER!r})"]
    return "\n".join([*lines, ""])

"""The commands that a session's steps run, from what its folder holds."""

import json
from collections.abc import Sequence

from acf_jax.app.current import diagnosed_by, surrogate_of
from acf_jax.app.sessions import CUTS, DATA, DIAGNOSIS, MAPPING, PLAN, RIG, SURROGATE, Session
from acf_jax.errors import InputError

CONDITIONS, DESCRIPTION, SLIDERS = f"{PLAN}/trials.csv", f"{PLAN}/dataset.yaml", f"{PLAN}/sliders.json"
LEARNT, HEADER, ONNX = f"{SURROGATE}/model.eqx", f"{SURROGATE}/peak.h", f"{SURROGATE}/peak.onnx"
MODEL = f"{DIAGNOSIS}/model.json"


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
    numbers = ["--sample-rate", f"{rate:g}", "--noise", f"{noise:g}"]
    return ["plan", DESCRIPTION, "--conditions", CONDITIONS, *numbers, "--json"]


def model_file(session: Session) -> str:
    """What answers: the surrogate where one was trained on the diagnosis, else its model."""
    return LEARNT if surrogate_of(session.folder / MODEL, session.folder / LEARNT) else MODEL


def planned(session: Session) -> list[str] | None:
    """The command of the last plan; None where there was none."""
    try:
        sliders = json.loads((session.folder / SLIDERS).read_text("utf-8"))
        return plan_command(float(sliders["rate"]), float(sliders["noise"]))
    except (OSError, ValueError, LookupError, TypeError):
        return None


def diagnosed(session: Session) -> list[str] | None:
    """The command of the diagnosis; None where there is none, or no data set to repeat it with."""
    if not (session.is_diagnosed and session.is_imported):
        return None
    without, low_pass = diagnosed_by(session)
    return diagnose_command(without) + (["--low-pass", f"{low_pass:g}"] if low_pass else [])

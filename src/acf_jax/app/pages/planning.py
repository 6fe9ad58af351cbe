"""Step 4, Plan: which effects trials could tell, before any is made."""

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

from starlette.responses import Response

from acf_jax.app import jobs
from acf_jax.app.commands import SLIDERS as KEPT
from acf_jax.app.pages.layout import button, faults_box, form, job_panel, note, page, running, slider
from acf_jax.app.sessions import DATA, RIG, Session
from acf_jax.documents import yaml_text
from acf_jax.errors import InputError, shown
from acf_jax.files import read_yaml_mapping
from acf_jax.report.markup import Html, element, table
from acf_jax.report.words import headed, listed, name_of

# name: (label, least, largest, step, at first, unit)
SLIDERS = {
    "slowest": ("Slowest contact velocity", 0.01, 0.5, 0.01, 0.05, "m/s"),
    "fastest": ("Fastest contact velocity", 0.02, 1.0, 0.01, 0.35, "m/s"),
    "speeds": ("Number of velocities", 1, 8, 1, 4, ""),
    "least": ("Least pretension", 0, 300, 5, 50, "N"),
    "most": ("Largest pretension", 0, 500, 5, 90, "N"),
    "pretensions": ("Number of pretensions", 1, 6, 1, 2, ""),
    "repeats": ("Repeats of each", 1, 6, 1, 2, ""),
    "rate": ("Sampling rate of the force", 1000, 20000, 500, 8000, "Hz"),
    "noise": ("Noise of one sample", 0.1, 10, 0.1, 1.0, "N"),
}
MOST = 200  # trials
DETECTED = 3  # standard deviations at which an effect counts as detected, as in `smallest_detectable`


def planning(
    session: Session, faults: Sequence[str] = (), entered: Mapping[str, str] | None = None
) -> Response:
    """The page."""
    job = jobs.job(session.folder, "plan")
    busy = running(session)
    values = _values(session, entered)
    sliders = [slider(name, s[0], *s[1:4], values[name], s[5]) for name, s in SLIDERS.items()]
    buttons: list[Html] = [
        button(
            "What would these trials show?",
            class_="first",
            name="of",
            value="sliders",
            disabled=busy is not None,
        )
    ]
    if session.is_imported:
        buttons.append(
            button(
                "What can this session's trials tell?", name="of", value="trials", disabled=busy is not None
            )
        )
    failed = [line.removeprefix("error: ") for line in job.messages] if job and job.state == "failed" else []
    first = element("a", "Describe the rig", href=f"{session.url}/rig")
    count = element("p", id="plan-count", role="status", aria_live="polite")
    return page(
        "Plan",
        job_panel(session, busy),
        faults_box([*faults, *failed]),
        None if session.has_rig else note(first, " first: what a trial shows depends on it."),
        form(f"{session.url}/plan", *sliders, count, element("div", *buttons, class_="row"), id="plan"),
        _answer(job) if job and job.state == "done" else None,
        session=session,
        step="plan",
        scripts=("plan.js",),
        status=400 if faults else 200,
    )


def trials(fields: Mapping[str, str]) -> tuple[str, dict[str, float]]:
    """trials.csv of the sliders, and their values; `InputError` where they cannot be."""
    import numpy as np

    faults, values = [], {}
    for name, (label, low, high, _, _, unit) in SLIDERS.items():
        try:
            values[name] = float(fields.get(name, ""))
        except ValueError:
            faults.append(f"{label}: {shown(fields.get(name, ''))} is no number; move the slider")
            continue
        if not low <= values[name] <= high:
            faults.append(f"{label}: must lie between {low:g} and {high:g} {unit}; move the slider")
    if not faults and values["slowest"] > values["fastest"]:
        faults.append("Slowest contact velocity: is above the fastest; move one of them")
    if not faults and values["least"] > values["most"]:
        faults.append("Least pretension: is above the largest; move one of them")
    if faults:
        raise InputError(faults)
    speeds = np.unique(np.linspace(values["slowest"], values["fastest"], round(values["speeds"])))
    levels = np.unique(np.linspace(values["least"], values["most"], round(values["pretensions"])))
    pairs = [
        (v, p) for p in levels.tolist() for v in speeds.tolist() for _ in range(round(values["repeats"]))
    ]
    if not 3 <= len(pairs) <= MOST:
        raise InputError(
            f"{len(pairs)} trials: must be 3 to {MOST}; change velocities, pretensions or repeats"
        )
    lines = [f"t{i:03d},{v:.4g},{p:.4g}" for i, (v, p) in enumerate(pairs)]
    return "\n".join(["trial,contact_velocity_m_per_s,pretension_n", *lines, ""]), values


def description(session: Session) -> str:
    """The rig's file that `plan` reads: the session's."""
    path = session.folder / (RIG if session.has(RIG) else f"{DATA}/dataset.yaml")
    if not path.is_file():
        raise InputError("the rig is not described yet; describe it first")
    content = read_yaml_mapping(path)
    return yaml_text({key: value for key, value in content.items() if key in ("rig", "measurement")})


def _values(session: Session, entered: Mapping[str, str] | None) -> dict[str, float]:
    """Where the sliders stand: as entered, else as they were last time, else as they begin."""
    known: Mapping[str, Any] = entered or {}
    if entered is None:
        with suppress(OSError, ValueError):
            content = json.loads((session.folder / KEPT).read_text("utf-8"))
            known = content if isinstance(content, dict) else {}
    values = {}
    for name, (_, low, high, _, first, _) in SLIDERS.items():
        try:
            values[name] = min(max(float(known[name]), low), high)
        except (LookupError, TypeError, ValueError):
            values[name] = float(first)
    return values


def _answer(job: jobs.Job) -> Html:
    try:
        content: dict[str, Any] = json.loads(job.output.read_text("utf-8"))
        rows = [_row(effect) for effect in content["effects"]]
        caption = f"At {content['sample_rate_hz']:g} Hz with a noise of {content['noise_n']:g} N"
    except (OSError, ValueError, LookupError, TypeError):
        return note("The answer is damaged; ask again.", mood="bad")
    head = ("Effect", "Smallest size that would show", "Typical size", "Not told apart from")
    return element("section", element("h2", "What these trials would show", id="answer"), table(caption, head, rows),
                   aria_labelledby="answer")  # fmt: skip


def _row(effect: Mapping[str, Any]) -> tuple[object, ...]:
    smallest = effect["smallest_detectable"]
    unit = "" if effect["unit"] == "1" else f" {effect['unit']}"
    size: object = (
        element("span", "not at all", class_="bad") if smallest is None else f"{float(smallest):.3g}{unit}"
    )
    distance = effect["distance_at_typical_size"]
    shows = "shows" if distance is not None and float(distance) > DETECTED else "would hardly show"
    twins = (
        listed([headed(name_of((name,))) for name in effect["confused_with"]])
        if effect["confused_with"]
        else "–"
    )
    return headed(name_of((effect["effect"],))), size, shows, twins

"""Step 6, Use: sliders, allowed speed, design, contact with people, and what is taken away."""

import math
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

from starlette.responses import Response

from acf_jax.app import jobs
from acf_jax.app.commands import HEADER, LEARNT, MODEL, ONNX
from acf_jax.app.current import is_made_of, surrogate_of
from acf_jax.app.pages.layout import (
    button,
    faults_box,
    field,
    form,
    job_panel,
    note,
    number,
    outdated,
    page,
    running,
    select,
    slider,
)
from acf_jax.app.questions import call_of, keep
from acf_jax.app.sessions import DIAGNOSIS, Session
from acf_jax.errors import InputError
from acf_jax.report.markup import Html, bullets, element, join
from acf_jax.report.plot import Variant, axis, plot

GOALS = (
    ("fastest", "as fast as possible"),
    ("highest_process_force", "highest process force"),
    ("widest_margin", "widest margin"),
)
CONTACTS = (("quasi_static", "clamped (quasi-static)"), ("transient", "free to recoil (transient)"))


def using(session: Session, faults: Sequence[str] = ()) -> Response:
    """The page."""
    busy = running(session)
    ended = (jobs.job(session.folder, "train"), jobs.job(session.folder, "export"))
    last = [job for job in ended if job and job.state == "failed"]
    told = [line.removeprefix("error: ") for job in last for line in job.messages]
    body: list[object] = [faults_box([*faults, *told]), job_panel(session, busy)]
    if not session.is_diagnosed:
        body.append(
            note(
                element("a", "Diagnose", href=f"{session.url}/diagnose"),
                " first: its corrected model answers here.",
            )
        )
        return page("Use", *body, session=session, step="use")
    body.append(outdated(session))
    try:
        body += [_sliders(session), _questions(session)]
    except InputError as error:
        body.append(faults_box(error.faults, "The model of this diagnosis gives no answers"))
    body.append(_downloads(session))
    return page("Use", *body, session=session, step="use", scripts=("use.js",))


def model_of(session: Session) -> Any:
    """The model behind the page; `InputError` where nothing may be built on it."""
    from acf_jax.app import live

    model = live.model_of(session.folder / DIAGNOSIS, session.folder / LEARNT)
    model.source.exact.check_carried()
    return model


def answer(session: Session, question: str, fields: Mapping[str, str]) -> dict[str, Any]:
    """The answer to a question as HTML; `InputError` for one that cannot be asked."""
    model = model_of(session)
    call = call_of(question, fields)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # an answer shows its notes itself
        found = getattr(model, question)(**call)
    keep(session, question, fields)
    return {"html": found._repr_html_()}


def _sliders(session: Session) -> Html:
    from acf_jax.app import live

    model = model_of(session)
    spans = live.spans(model)
    words = {
        "v_e": ("Contact velocity", "m/s", 0.001),
        "f_p": ("Pretension", "N", 0.5),
        "stiffness": ("Contact stiffness, over the fitted one", "×", 0.01),
        "limit": ("Limit of the peak force", "N", 1.0),
    }
    rows = []
    for name, (low, high, first) in spans.items():
        label, unit, step = words[name]
        rows.append(slider(name, label, _up(low, step), _down(high, step), step, _down(first, step), unit))
    layout = {
        "xaxis": axis("contact velocity / m/s", automargin=False),
        "yaxis": axis("peak contact force / N", rangemode="tozero", automargin=False),
    }
    caption = (
        "The band is 1.96 standard deviations wide either way, to first order: parameters, explanations and the form of"
        " the law."
        " Dotted: beyond the trials, where the model extrapolates. Dashed: the limit."
    )
    figure = plot("peak", "Peak contact force", caption, [Variant("", [])], layout, 360)
    source = model.source
    who = (
        "the surrogate that was trained on it" if source.trained else "the simulation of the corrected model"
    )
    if not source.trained and not getattr(source.exact.main.peak, "effects", ()):
        who = "the paper's equations with the refitted rig"
    told = element(
        "p",
        f"Answered by {who}. The questions below draw everything uncertain, and say when the robot must stop.",
        class_="muted",
    )
    said = element("output", id="peak-said", for_=" ".join(spans), aria_live="polite", class_="verdict")
    notes = element("ul", id="peak-notes", class_="muted")
    inputs = form(f"{session.url}/curve", *rows, id="sliders", data_curve=f"{session.url}/curve")
    return element("section", element("h2", "How hard does it press?", id="sliders-title"),
                   element("div", element("div", inputs, said, notes, told), figure, class_="beside"),
                   aria_labelledby="sliders-title")  # fmt: skip


def _questions(session: Session) -> Html:
    from acf_jax.safety.limits import read_limits

    areas = [(a.number or a.name, f"{a.name} ({a.region})") for a in read_limits().areas if a.is_permissible]
    tried = model_of(session).source.exact.tried
    (v_low, v_high), (f_low, f_high) = (tried.v_e, tried.f_p) if tried else ((0.05, 0.35), (50, 90))
    ask = button("Ask", class_="first")

    def question(name: str, title: str, *body: Html) -> Html:
        asked = form(
            f"{session.url}/ask/{name}",
            element("div", *body, ask, class_="row"),
            class_="ask",
            id=f"ask-{name}",
        )
        out = element("div", class_="answer", role="status", aria_live="polite", id=f"answer-{name}")
        return element(
            "section", element("h3", title, id=f"{name}-title"), asked, out, aria_labelledby=f"{name}-title"
        )

    def entry(name: str, key: str, label: str, value: float | str) -> Html:
        identity = f"{name}-{key}"
        control = number(identity, f"{value:g}" if isinstance(value, float | int) else value, size=8)
        return field(label, Html(control.replace(f'name="{identity}"', f'name="{key}"')), identity)

    def choice(name: str, key: str, label: str, pairs: Sequence[tuple[str, str]]) -> Html:
        control = select(f"{name}-{key}", pairs, pairs[0][0])
        return field(label, Html(control.replace(f'name="{name}-{key}"', f'name="{key}"')), f"{name}-{key}")

    return join(
        [
            element("h2", "Ask the model"),
            question(
                "speed", "Highest allowed speed",
                entry("speed", "f_p", "Pretension, N", f_high), entry("speed", "limit", "Limit of the peak, N", 140),
            ),
            question(
                "design", "Best setting",
                entry("design", "limit", "Limit, N", 140), entry("design", "v-low", "Velocity from, m/s", v_low),
                entry("design", "v-high", "to, m/s", v_high), entry("design", "f-low", "Pretension from, N", f_low),
                entry("design", "f-high", "to, N", f_high), choice("design", "goal", "Goal", GOALS),
            ),
            question(
                "check", "Contact with a person",
                choice("check", "area", "Body area (ISO/TS 15066)", areas),
                entry("check", "v", "Velocity, m/s", v_high), entry("check", "f_p", "Pretension, N", f_high),
                choice("check", "contact", "The body is", CONTACTS),
                entry("check", "stop", "Robot stopped after, s, if known", ""),
            ),
        ]
    )  # fmt: skip


def _downloads(session: Session) -> Html:
    url = session.url
    links = [
        _link(
            f"{url}/file/{DIAGNOSIS}/report.html?download=1",
            "Report, HTML",
            session.has(DIAGNOSIS, "report.html"),
        ),
        _link(f"{url}/report.pdf", "Report, PDF", session.has(DIAGNOSIS, "report.html")),
        _link(f"{url}/file/{DIAGNOSIS}/model.json?download=1", "Corrected model, model.json", True),
        _link(f"{url}/file/{DIAGNOSIS}/diagnosis.json?download=1", "Diagnosis, diagnosis.json", True),
        _link(f"{url}/script.sh", "Script: the commands of every step", True),
        _link(f"{url}/script.py", "Script: the same in Python", True),
    ]
    learnt = surrogate_of(session.folder / MODEL, session.folder / LEARNT)
    has_net = learnt is not None
    outputs = ((LEARNT, "Surrogate, model.eqx"), (HEADER, "C99 header"), (ONNX, "ONNX model"))
    for name, word in outputs if has_net else ():
        is_new = name == LEARNT or is_made_of(session.folder / name, learnt)
        links.append(_link(f"{url}/file/{name}?download=1", word, is_new))
    told = " about a minute; answers on a controller"
    if session.has(LEARNT) and not has_net:
        told = " the one that is there is of an earlier diagnosis"
    train = form(f"{url}/train", button("Train a surrogate again" if has_net else "Train a surrogate"),
                 element("span", told, class_="muted"))  # fmt: skip
    export = form(f"{url}/export", button("Write C and ONNX")) if has_net else None
    return element("section", element("h2", "Take away", id="take-title"), bullets([link for link in links if link]),
                   element("div", train, export, class_="row"), aria_labelledby="take-title")  # fmt: skip


def _link(href: str, word: str, is_there: bool) -> Html | None:
    return element("a", word, href=href, download=True) if is_there else None


def _up(value: float, step: float) -> float:
    """The next step that is not below: the end of a slider lies within the range."""
    return round(math.ceil(value / step - 1e-6) * step, 6)


def _down(value: float, step: float) -> float:
    return -_up(-value, step)

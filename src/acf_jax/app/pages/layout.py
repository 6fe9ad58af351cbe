"""What all pages share: head, steps, messages, forms and the progress of a job."""

from collections.abc import Iterable, Sequence

from starlette.responses import HTMLResponse

from acf_jax import __version__
from acf_jax.app import jobs
from acf_jax.app.current import is_outdated
from acf_jax.app.jobs import Job
from acf_jax.app.sessions import Session
from acf_jax.report.markup import Html, bullets, element, escape, join, void

STEPS = (
    ("open", "Open"),
    ("cut", "Cut"),
    ("rig", "Rig"),
    ("plan", "Plan"),
    ("diagnose", "Diagnose"),
    ("use", "Use"),
)
DOING = {
    "import": "Cutting the recording",
    "diagnose": "Diagnosing",
    "plan": "Asking what these trials would show",
    "train": "Training a surrogate",
    "export": "Writing the export",
}
ENDED = {
    "done": ("good", "Done"),
    "failed": ("bad", "Ended without a result"),
    "stopped": ("open", "Cancelled; nothing is left half-written"),
    "interrupted": ("bad", "Interrupted: its process is gone. Nothing is left half-written; start it again"),
}
GOES_ON = {  # what a diagnosis has fitted is kept
    "stopped": "Cancelled; nothing is left half-written. Started again it goes on where it was",
    "interrupted": "Interrupted: its process is gone. Started again it goes on where it was",
}


def page(
    title: str,
    *body: object,
    session: Session | None = None,
    step: str = "",
    scripts: Sequence[str] = (),
    status: int = 200,
) -> HTMLResponse:
    """The whole page; `scripts` are modules of static/ beside those that every page has."""
    name = element("a", "acf-jax", href="/", class_="brand")
    where = [element("a", session.name, href=f"{session.url}/open", class_="where")] if session else []
    head = element("header", element("div", name, *where, class_="bar"), _steps(session, step))
    files = ("renew.js", "plotly.js", "page.js", "app.js", *scripts)
    loaded = join(element("script", src=f"/static/{file}", defer=True) for file in files)
    foot = element(
        "footer",
        element("p", f"acf-jax {__version__}. Everything stays on this machine. ", class_="muted"),
    )
    text = f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)}{escape(f" · {session.name}") if session else ""} · acf-jax</title>
<link rel="icon" href="/static/icon.svg">
<link rel="stylesheet" href="/static/style.css">
<link rel="stylesheet" href="/static/app.css">
</head>
<body>
<a class="skip" href="#main">Skip to the content</a>
{head}
<main id="main">
<h1 class="title">{escape(title)}</h1>
{join(part for part in body if part)}
</main>
{foot}
{loaded}
</body>
</html>
"""
    return HTMLResponse(text, status)


def _steps(session: Session | None, step: str) -> Html:
    """The steps of a session, or what there is without one."""
    links = [("/", "sessions", "Sessions"), ("/fleet", "fleet", "Fleet")]
    if session:
        links = [(f"{session.url}/{name}", name, f"{i} {word}") for i, (name, word) in enumerate(STEPS, 1)]
        links.append(("/fleet", "fleet", "7 Fleet"))
    items = (
        element("li", element("a", word, href=href, aria_current="page" if name == step else None))
        for href, name, word in links
    )
    return element("nav", element("ul", *items), aria_label="Steps" if session else "Pages")


def faults_box(faults: Sequence[str], heading: str = "This has to be mended first") -> Html:
    """What is wrong, each with its remedy."""
    if not faults:
        return Html("")
    return element("div", element("h2", heading), bullets(faults), class_="box faults", role="alert")


def note(*text: object, mood: str = "") -> Html:
    """A remark that stands out."""
    return element("div", element("p", *text), class_=f"box {mood}".strip())


def outdated(session: Session) -> Html:
    """A remark where the diagnosis is of another data set than the session's."""
    if not is_outdated(session):
        return Html("")
    return note("The data set is another than the one that was diagnosed: diagnose again.", mood="open")


def form(action: str, *body: object, **attributes: object) -> Html:
    """A form that is sent to this server."""
    return element("form", *body, method="post", action=action, **attributes)


def button(word: object, **attributes: object) -> Html:
    """A button; `class_="first"` is the one that leads on."""
    return element("button", word, **({"type": "submit"} | attributes))


def hidden(name: str, value: object) -> Html:
    """A value that a form carries along."""
    return void("input", type="hidden", name=name, value=value)


def field(label: str, control: Html, name: str, hint: object = "") -> Html:
    """A labelled control; its hint is read out with it."""
    parts = [element("label", label, for_=name), control]
    if hint:
        parts.append(element("p", hint, class_="muted hint", id=f"{name}-hint"))
    return element("div", *parts, class_="field")


def number(name: str, value: object, **attributes: object) -> Html:
    """A field for a number."""
    shown = "" if value is None else value
    return void(
        "input", id=name, name=name, inputmode="decimal", autocomplete="off", value=shown, **attributes
    )


def slider(name: str, label: str, low: float, high: float, step: float, value: float, unit: str) -> Html:
    """A slider with a field beside it that holds the same number; app.js keeps them together."""
    span = {"min": f"{low:g}", "max": f"{high:g}", "step": f"{step:g}"}
    return element(
        "div",
        element("label", label, for_=name),
        void(
            "input", type="range", id=name, name=name, value=f"{value:g}", data_pair=f"{name}-number", **span
        ),
        void(
            "input",
            type="number",
            id=f"{name}-number",
            value=f"{value:g}",
            aria_label=f"{label}, {unit}" if unit else label,
            **span,
        ),
        element("span", unit, class_="unit"),
        class_="slider",
    )


def options(pairs: Iterable[tuple[str, str]], chosen: str) -> Html:
    """Choices of a select."""
    return join(element("option", word, value=value, selected=value == chosen) for value, word in pairs)


def select(name: str, pairs: Iterable[tuple[str, str]], chosen: str, **attributes: object) -> Html:
    """A choice among few."""
    return element("select", options(pairs, chosen), id=name, name=name, **attributes)


def embedded(address: str, title: str) -> Html:
    """A page that a command wrote, in a sandbox of its own; page.js tells its height."""
    frame = element(
        "iframe", src=address, title=title, class_="embedded", sandbox="allow-scripts allow-downloads"
    )
    return join(
        [
            element(
                "p", element("a", f"{title}, alone in a tab", href=address, target="_blank", rel="noopener")
            ),
            frame,
        ]
    )


def job_panel(session: Session, job: Job | None) -> Html:
    """The progress of a running job, which app.js keeps up to date; of one that has ended how it ended."""
    if job is None:
        return Html("")
    word = DOING[job.kind]
    if not job.is_running:
        mood, said = ENDED[job.state]
        if job.kind == "diagnose":
            said = GOES_ON.get(job.state, said)
        if job.state == "done":
            return Html("")
        return join(
            [
                note(element("strong", f"{word}: "), said, ".", mood=mood),
                faults_box([_told(line) for line in job.messages]),
            ]
        )
    return element(
        "section",
        element("h2", word, id="job-title"),
        element("progress", aria_labelledby="job-title", id="job-progress", max=1),
        element("p", "starting", id="job-said", role="status", aria_live="polite", class_="quiet"),
        element("p", "starting", id="job-clock", class_="muted", aria_hidden="true"),
        *(element("p", line, class_="muted") for line in job.messages if line.startswith("note: ")),
        element("ol", id="job-stages", class_="stages", aria_label="Stages"),
        form(f"{session.url}/cancel", button("Cancel")),
        class_="box job",
        id="job",
        data_events=f"{session.url}/events",
        data_known=len(job.known),
        aria_labelledby="job-title",
    )


def running(session: Session) -> Job | None:
    """The job that runs in a session, of whatever kind."""
    job = jobs.last(session.folder)
    return job if job and job.is_running else None


def _told(line: str) -> str:
    return line.removeprefix("error: ")

"""Step 2, Cut: the page that `import` writes, whose button saves cuts.yaml here and cuts the recording again."""

from collections.abc import Sequence
from typing import Any

from starlette.responses import Response

from acf_jax.app import jobs, signals
from acf_jax.app.pages.layout import button, embedded, faults_box, form, hidden, job_panel, note, page
from acf_jax.app.pages.opening import offers
from acf_jax.app.pages.roles import WORDS
from acf_jax.app.sessions import CUTS, DATA, MAPPING, Session
from acf_jax.forms import check_form
from acf_jax.recording.review import AUTO, SCHEMA, Entry, Review, review_text
from acf_jax.recording.write import CUTS as PAGE
from acf_jax.recording.write import REFUSED
from acf_jax.report.markup import Html, element, join


def cutting(session: Session, faults: Sequence[str] = ()) -> Response:
    """The page."""
    job = jobs.job(session.folder, "import")
    busy = job is not None and job.is_running
    shown = _shown(session)
    found = [line.removeprefix("error: ") for line in job.messages] if job and job.state == "failed" else []
    body: list[object] = [faults_box(faults)]
    if busy or (job and job.state != "done" and not found):
        body.append(job_panel(session, job))
    elif found:
        body += [faults_box(found, "No data set came of it"), _remedies(session, found)]
    if session.is_imported and not busy:
        following = ("rig", "Describe the rig") if not session.has_rig else ("diagnose", "Diagnose")
        body.append(
            element(
                "p", element("a", following[1], href=f"{session.url}/{following[0]}", class_="button first")
            )
        )
    if shown and not busy:
        frame = embedded(f"{session.url}/file/{DATA}/{shown}", "Cuts")
        body.append(
            element(
                "div", frame, id="cuts", data_version=session.version(CUTS), data_save=f"{session.url}/cuts"
            )
        )
    elif not busy and not found:
        body.append(
            note(
                "Nothing is cut yet. ",
                element("a", "Choose the signals", href=f"{session.url}/open"),
                " first.",
            )
        )
    if session.has(CUTS) and not busy:
        body.append(
            form(
                f"{session.url}/forget-cuts",
                hidden("version", session.version(CUTS)),
                element("p", "cuts.yaml decides about these contacts."),
                button("Forget what was decided, and cut anew"),
                class_="after",
            )
        )
    return page("Cut", *body, session=session, step="cut", scripts=("cut.js",))


def review_of(session: Session, cuts: Any) -> str:
    """cuts.yaml of what the page sends; `InputError` where it is none."""
    recording = session.recording()
    name = recording.name if recording else ""
    review = check_form(Review, {"schema": SCHEMA, "recording": name, "cuts": cuts}, CUTS)
    return review_text(name, [(Entry.model_validate(_as_written(entry)), "") for entry in review.cuts])


def _as_written(entry: Entry) -> dict[str, Any]:
    return {
        "trial": entry.trial,
        "contact_s": entry.contact_s,
        "keep": AUTO if entry.keep is None else entry.keep,
    }


def _shown(session: Session) -> str | None:
    """The page of the last import: an import that comes well removes that of a refused one."""
    return next((name for name in (REFUSED, PAGE) if session.has(DATA, name)), None)


def _remedies(session: Session, faults: Sequence[str]) -> Html:
    """A button for each factor that a message names."""
    content = signals.read(session.folder / MAPPING)
    buttons = [
        form(
            f"{session.url}/rescale",
            hidden("version", session.version(MAPPING)),
            hidden("role", remedy.role),
            hidden("factor", f"{remedy.factor!r}"),
            button(_word(remedy), class_="first"),
        )
        for remedy in signals.remedies(faults, content, offers(session))
    ]
    back = element("a", "Choose other signals, signs or units", href=f"{session.url}/open")
    return element("div", *buttons, element("p", back), class_="after")


def _word(remedy: signals.Remedy) -> Html:
    what = WORDS[remedy.role].lower()
    if remedy.factor == -1.0:
        return join(["Turn the sign of the ", what, ", and cut again"])
    return join(["Multiply the ", what, f" by {remedy.factor:g}, and cut again"])

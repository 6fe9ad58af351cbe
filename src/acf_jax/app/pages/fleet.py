"""Step 7, Fleet: sessions beside one another, and what changed since an earlier comparison."""

from collections.abc import Sequence
from urllib.parse import quote

from starlette.responses import Response

from acf_jax.app import fleets, sessions
from acf_jax.app.pages.diagnosing import verdict_of
from acf_jax.app.pages.layout import button, embedded, faults_box, form, note, page
from acf_jax.app.security import Places
from acf_jax.report.markup import Html, element, void
from acf_jax.report.words import VERDICTS


def fleet(places: Places, shown: str = "", faults: Sequence[str] = ()) -> Response:
    """The page; `shown`: the comparison that is looked at."""
    known = fleets.earlier(places.folders[0])
    diagnosed = [session for session in sessions.every(places) if session.is_diagnosed]
    body: list[object] = [faults_box(faults)]
    if diagnosed:
        body.append(_form(diagnosed, known))
    else:
        body.append(note("No session is diagnosed yet; two or more are worth comparing."))
    if known:
        links = (
            element("li", element("a", name, href=f"/fleet?shown={quote(name)}")) for name in reversed(known)
        )
        body.append(
            element(
                "section",
                element("h2", "Comparisons", id="known"),
                element("ul", *links),
                aria_labelledby="known",
            )
        )
    if shown in known:
        # the frame is in a sandbox and may not open them itself
        whole = (
            element("li", element("a", rig, href=f"/fleet/{quote(shown)}/{quote(rig)}/report.html"))
            for rig in fleets.reports(places.folders[0], shown)
        )
        body += [element("h2", "Reports of the rigs"), element("ul", *whole)]
        body.append(embedded(f"/fleet/{quote(shown)}/index.html", f"Comparison {shown}"))
    return page("Fleet", *body, step="fleet")


def _form(diagnosed: Sequence[sessions.Session], known: Sequence[str]) -> Html:
    rigs = [
        element(
            "li",
            void(
                "input",
                type="checkbox",
                name="session",
                value=f"{s.place}/{s.name}",
                id=f"s{i}",
                checked=True,
            ),
            element("label", f" {s.name}: {_word(s)}", for_=f"s{i}"),
        )
        for i, s in enumerate(diagnosed)
    ]
    before = [
        element(
            "li",
            void("input", type="checkbox", name="since", value=name, id=f"b{i}", checked=name == known[-1]),
            element("label", f" {name}", for_=f"b{i}"),
        )
        for i, name in enumerate(known)
    ]
    parts = [
        element("fieldset", element("legend", "Rigs: a session each"), element("ul", *rigs, class_="plain"))
    ]
    if before:
        parts.append(
            element("fieldset", element("legend", "Compared with"), element("ul", *before, class_="plain"))
        )
    return form("/fleet", *parts, button("Compare", class_="first"))


def _word(session: sessions.Session) -> str:
    verdict = verdict_of(session)
    return VERDICTS[verdict][0] if verdict in VERDICTS else "damaged"

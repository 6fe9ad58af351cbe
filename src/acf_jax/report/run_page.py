"""`index.html` of a run: from a recording to allowed speeds on one page, the verdict first."""

from collections.abc import Sequence
from typing import NamedTuple

from acf_jax import __version__
from acf_jax.designs.remedy import Infeasible
from acf_jax.designs.solve import Design
from acf_jax.designs.speed import Speeds
from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.report import check_text, speed_text
from acf_jax.report.markup import Html, bullets, details, element, join, table
from acf_jax.report.page import page, part
from acf_jax.report.trusted import trusted
from acf_jax.report.words import VERDICTS, advice, doubts, made_of, shrunk, trust, verdict
from acf_jax.safety.check import Answer, Checker
from acf_jax.safety.limits import Limits

IMPORT, REPORT = "data/import.html", "diagnosis/report.html"  # beside the page


class Outcome(NamedTuple):
    """How far a run came and what it found; each step needs the one before."""

    recording: str
    limit: float  # N, of the peak contact force
    found: Sequence[str]  # of the import, in words
    stopped: Sequence[str] = ()  # why the run went no further; empty where it did
    diagnosis: Diagnosis | None = None
    speeds: Sequence[tuple[float, Speeds]] = ()  # by pretension, N
    check: tuple[Answer, Checker, Limits] | None = None  # of a contact with a person

    @property
    def is_allowed(self) -> bool:
        """Whether a pretension has a speed, and the contact, if it was asked for, is allowed."""
        is_found = any(isinstance(x.found[0], Design) for _, x in self.speeds)
        return is_found and (self.check is None or self.check[0].verdict == "allowed")

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader has to know of all speeds."""
        return tuple(dict.fromkeys(note for _, speeds in self.speeds for note in speeds.notes))


def run_page(run: Outcome, origin: str = "") -> str:
    """The page; `origin`: how it came about."""
    d = run.diagnosis
    steps = [element("span", element("a", "Every cut of the recording", href=IMPORT), f": {run.found[0]}")]
    if d is not None:
        link = element("a", "The whole diagnosis", href=REPORT)
        steps.append(element("span", link, f": {made_of(d)}" if made_of(d) else ""))
    remarks = list(dict.fromkeys([*run.found[1:], *(doubts(d) if d else [])]))
    parts = [
        part("stopped", "Stopped", "Why the run went no further", bullets(run.stopped) if run.stopped else None),
        part("speeds", "Speeds", f"Highest velocity within {run.limit:g} N", _speeds(run)),
        part("contact", "Contact", "Contact with a person", _contact(run)),
        part(
            "steps", "Steps", "What it rests on", bullets(steps),
            details("Remarks", bullets(remarks)) if remarks else None,
        ),
    ]  # fmt: skip
    foot = element("p", f"acf-jax {__version__}. SI units. {origin}", class_="muted")
    return page(f"Allowed speeds: {run.recording}", _head(run), [p for p in parts if p], foot)


def _head(run: Outcome) -> Html:
    d = run.diagnosis
    title = element("h1", f"From {run.recording} to allowed speeds")
    if d is None:
        refused = element("span", "No diagnosis: ", class_="tag bad")
        return join([title, element("p", refused, run.stopped[0], class_="verdict")])
    tag, mood = VERDICTS[d.verdict]
    says = verdict(d).split(": ", 1)[-1]
    lines = [element("p", line) for line in (shrunk(d), advice(d)) if line]
    return join(
        [
            title,
            trusted(trust(d)),
            element("p", element("span", f"{tag}: ", class_=f"tag {mood}"), says, class_="verdict"),
            *lines,
        ]
    )


def _speeds(run: Outcome) -> Html | None:
    if not run.speeds:
        return None
    rows: list[tuple[str, ...]] = []
    for f_p, speeds in run.speeds:
        x = speeds.found[0]
        if isinstance(x, Infeasible):
            rows.append((f"{f_p:.4g} N", speed_text.why_none(x), "–", "–"))
            continue
        end = speed_text.why_end(x)
        speed = f"{speed_text.speed(x)}{f' ({end})' if end else ''}"
        rows.append((f"{f_p:.4g} N", speed, f"{x.force:.1f} N", speed_text.stop(x)))
    probability = run.speeds[0][1].found[0].task.probability
    caption = f"At pretensions that were tried; the peak stays within the limit with a probability of {probability:g}"
    head = ("Pretension", "Highest velocity", "Expected force", "Robot must stop within")
    notes = bullets(run.notes) if run.notes else join([])
    return join([table(caption, head, rows), notes])


def contact_lines(run: Outcome) -> list[str]:
    """What a person reads of the check; nothing where none was asked for."""
    return check_text.text(*run.check).splitlines() if run.check else []


def _contact(run: Outcome) -> Html | None:
    if run.check is None:
        return None
    head, *lines = contact_lines(run)
    return join([element("p", element("strong", head)), bullets(line.strip(" -") for line in lines)])

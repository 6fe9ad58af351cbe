"""HTML from values: every text that comes in is escaped here, and nowhere else."""

import html
import re
from collections.abc import Iterable, Sequence

GREEK = {"beta": "β", "chi": "χ", "omega": "ω", "sigma": "σ", "tau": "τ", "zeta": "ζ"}
UNIT = re.compile(r"(?<=\d) (?=(%|N|m/s|ms|Hz|σ)(?!\w))")  # the space that must not break a line


class Html(str):
    """Text that is HTML already."""


def escape(value: object) -> Html:
    """HTML of a value; `Html` stays as it is."""
    if isinstance(value, Html):
        return value
    return Html(UNIT.sub("\u00a0", html.escape(str(value))))


def formula(text: str) -> Html:
    """HTML of a text with symbols such as k_C and omega_s^2 as they are printed."""
    shown = re.sub(rf"(?<![A-Za-z_])({'|'.join(GREEK)})(?![A-Za-z])", lambda m: GREEK[m[1]], escape(text))
    shown = re.sub(r"(?<![A-Za-z_])([^\W\d_])_([A-Za-z]+|\d)\b", r"\1<sub>\2</sub>", shown)
    return Html(re.sub(r"\^(\d)", r"<sup>\1</sup>", shown))


def element(tag: str, *children: object, **attributes: object) -> Html:
    """`<tag ...>children</tag>`; `class_` stands for class, `_` for `-`, an attribute that is True has no value."""
    kept = {name: value for name, value in attributes.items() if value is not None and value is not False}
    written = "".join(_attribute(name, value) for name, value in kept.items())
    return Html(f"<{tag}{written}>{join(children)}</{tag}>")


def void(tag: str, **attributes: object) -> Html:
    """The same of an element that holds nothing, such as input."""
    return Html(element(tag, **attributes).removesuffix(f"</{tag}>"))


def join(parts: Iterable[object]) -> Html:
    """Parts one behind the other; None stands for a part that is not there."""
    return Html("".join(escape(part) for part in parts if part is not None))


def bullets(items: Iterable[object]) -> Html:
    """A list."""
    return element("ul", *(element("li", item) for item in items))


def table(caption: str, head: Sequence[str], rows: Iterable[Sequence[object]]) -> Html:
    """A table whose first column names the row; on a phone each row becomes a block of labelled lines."""
    body = []
    for row in rows:
        first = element("th", row[0], scope="row")
        cells = [
            element("td", element("div", cell), data_label=label)
            for label, cell in zip(head[1:], row[1:], strict=True)
        ]
        body.append(element("tr", first, *cells))
    columns = element("tr", *(element("th", label, scope="col") for label in head))
    return element("table", element("caption", caption), element("thead", columns), element("tbody", *body))


def sortable_table(
    caption: str, head: Sequence[str], rows: Iterable[Sequence[tuple[object, str | float | None]]]
) -> Html:
    """The same with each cell's key beside it; page.js sorts by a column's keys when its name is pressed."""
    body = []
    for (first, key), *others in rows:
        cells = [
            element("td", element("div", cell), data_label=label, data_key=own)
            for label, (cell, own) in zip(head[1:], others, strict=True)
        ]
        body.append(element("tr", element("th", first, scope="row", data_key=key), *cells))
    columns = element(
        "tr", *(element("th", element("button", label, type="button"), scope="col") for label in head)
    )
    parts = element("caption", caption), element("thead", columns), element("tbody", *body)
    return element("div", element("table", *parts, class_="sortable"), class_="wide")


def details(summary: object, *body: object) -> Html:
    """A part that opens on demand."""
    return element("details", element("summary", summary), *body)


def section(name: str, heading: str, *body: object) -> Html:
    """A part of the page that the contents can link to."""
    title = element("h2", heading, id=f"{name}-title")
    return element("section", title, *body, id=name, aria_labelledby=f"{name}-title")


def _attribute(name: str, value: object) -> str:
    key = name.rstrip("_").replace("_", "-")
    return f" {key}" if value is True else f' {key}="{html.escape(str(value))}"'

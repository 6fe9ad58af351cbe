"""The page around the sections: one file that needs nothing else, and runs no script but its own."""

import hashlib
from base64 import b64encode
from collections.abc import Sequence
from importlib.resources import files
from typing import NamedTuple

from plotly.offline import get_plotlyjs

from acf_jax.provenance import PROGRAM
from acf_jax.report.markup import Html, element, escape, join, section
from acf_jax.style import stylesheet


class Part(NamedTuple):
    """A section and the word that the contents have for it."""

    name: str
    word: str
    html: Html


def part(name: str, word: str, heading: str, *body: Html | None) -> Part | None:
    """A section of what there is; None where there is nothing."""
    there = [b for b in body if b]
    return Part(name, word, section(name, heading, *there)) if there else None


def page(title: str, head: Html, parts: Sequence[Part], foot: Html, script: str = "") -> str:
    """The HTML file: head, contents, sections, foot. `script`: runs before page.js draws the figures.

    The content security policy names the hashes of the scripts, so that a text which slipped through unescaped
    would still not run, and forbids every connection.
    """
    folder = files("acf_jax.report")
    scripts = (get_plotlyjs(), *([script] if script else []), (folder / "page.js").read_text("utf-8"))
    hashes = " ".join(f"'sha256-{b64encode(hashlib.sha256(s.encode()).digest()).decode()}'" for s in scripts)
    policy = f"default-src 'none'; script-src {hashes}; style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'"
    links = element("ul", *(element("li", element("a", p.word, href=f"#{p.name}")) for p in parts))
    contents = element("nav", links, aria_label="Contents") if len(parts) > 1 else ""
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="generator" content="{PROGRAM}">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)}</title>
<style>
{stylesheet()}</style>
</head>
<body>
<a class="skip" href="#main">Skip to the results</a>
<header>{head}{contents}</header>
<main id="main">
<noscript><p>The figures need JavaScript; texts and tables do not.</p></noscript>
{join(p.html for p in parts)}
</main>
<footer>{foot}</footer>
{join(element("script", Html(text)) for text in scripts)}
</body>
</html>
"""


def figure_page(title: str, figure: Html) -> str:
    """The page of a figure that stands alone."""
    return page(title, element("h1", title), [Part("figure", "Figure", element("section", figure))], Html(""))

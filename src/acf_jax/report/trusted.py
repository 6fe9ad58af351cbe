"""Whether the data can be trusted, on top of a page."""

from collections.abc import Sequence

from acf_jax.dataset.trust import Trust
from acf_jax.report.markup import Html, bullets, details, element


def trusted(trust: Trust) -> Html:
    """The headline; what limits the data, with the remedies, opens on demand."""
    return headed_by(trust.headline, trust.lines)


def headed_by(headline: str, limits: Sequence[str]) -> Html:
    """The same of its texts."""
    if not limits:
        return element("p", headline, class_="trust good")
    lines = (line[:1].upper() + line[1:].removesuffix(".") + "." for line in limits)
    return element("div", details(headline, bullets(lines)), class_="trust open")

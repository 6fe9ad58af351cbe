"""Whether the data can be trusted, on top of a page."""

from acf_jax.dataset.trust import Trust
from acf_jax.report.markup import Html, bullets, details, element


def trusted(trust: Trust) -> Html:
    """The headline; what limits the data, with the remedies, opens on demand."""
    if not trust.limits:
        return element("p", trust.headline, class_="trust good")
    lines = (line[:1].upper() + line[1:].removesuffix(".") + "." for line in trust.lines)
    return element("div", details(trust.headline, bullets(lines)), class_="trust open")

"""The one style of every page, figure and report."""

import re
from functools import cache
from pathlib import Path

_FILE = Path(__file__).with_name("style.css")


@cache
def stylesheet() -> str:
    """The CSS of a page: light, dark, on a phone, in print."""
    return _FILE.read_text("utf-8")


@cache
def colours(dark: bool = False) -> dict[str, str]:
    """What a light, or a dark, page shows for each name such as `--corrected`."""
    light, after = stylesheet().split("}", 1)
    found = _names(light[light.index(":root {") :])
    if dark:
        found |= _names(after[after.index(":root {") : after.index("}")])
    return found


def _names(rule: str) -> dict[str, str]:
    return dict(re.findall(r"(--[\w-]+): ([^;]+);", rule))

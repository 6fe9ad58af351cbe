"""The words of the documentation: standard terms, no coined ones, and no diary of how something came about."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
CODE = re.compile(r"^ *```.*?^ *```$|`[^`\n]*`", re.DOTALL | re.MULTILINE)  # programs say what they say
DIARY = "say what is true now; CHANGELOG.md says what changed"
BANNED = {
    r"since then|was once|used to be|no longer|(earlier|previous) version|version before|day before": DIARY,
    r"archaeolog\w*": DIARY,
    r"until 20\d\d-\d\d-\d\d|since 20\d\d-\d\d-\d\d": DIARY,
    r"own (parameter|nuisance|state|block)s?": "'parameter', 'nuisance' or 'state'",
    r"ports?": "'hook', or 'free curve'",
    r"owes?|owed": "'optimism': how much chi-square rises on conditions not used in the fit",
    r"price of freedom": "'Occam factor'",
    r"neutral at zero|neutral limit": "a strength of 0 disables the effect",
    r"unseen|untried": "'held out'",
    r"(left|leaves?|leaving) open": "'not determined by the data'",
}


def faults(text: str) -> list[str]:
    prose = " ".join(CODE.sub(" ", text).split())
    return [
        f"'{found[0]}' in '{prose[max(0, found.start() - 40) : found.end() + 40]}': {instead}"
        for pattern, instead in BANNED.items()
        for found in re.finditer(rf"\b({pattern})\b", prose, re.IGNORECASE)
    ]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_banned_words_do_not_come_back(page):
    assert faults(page.read_text("utf-8")) == []


@pytest.mark.parametrize(
    "text, caught",
    [
        ("What a fit owes to the\ndata that it has seen counts.", 1),
        ("It was once a seed of its own; since then it is no longer.", 3),
        ("Until 2026-11-24 each port had its own parameters.", 3),
        ("A report imports `ports` of its own.", 0),
        ("```text\nno longer\n```", 0),
    ],
)
def test_words_are_found_in_prose_alone(text, caught):
    assert len(faults(text)) == caught


def test_the_library_calls_held_out_what_a_fit_did_not_use():
    sources = sorted((ROOT / "src").rglob("*.py"))
    assert [f.name for f in sources if "unseen" in f.read_text("utf-8").lower()] == []


def test_each_term_is_explained_in_one_sentence():
    rows = re.findall(r"^\| (.+?) \| (.+) \|$", (ROOT / "docs/terms.md").read_text("utf-8"), re.MULTILINE)[1:]
    terms = [term.lower() for term, _ in rows]
    assert terms == sorted(set(terms))
    assert {"nuisance", "state", "marginal likelihood", "optimism", "sampling rate"} <= set(terms)
    for term, meaning in rows:
        assert re.fullmatch(r"[A-Z][^.]*(\.md[^.]*)*\.", meaning), term

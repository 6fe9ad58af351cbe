"""The site's summary of the benchmarks says what the tables say that the commands wrote."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ROW = re.compile(r"^\|(?!--|\s*\|).+\|$", re.MULTILINE)


def numbers(text: str) -> set[str]:
    return set(re.findall(r"(?<![\w.-])\d[\d.]*(?:e-\d+)?", text.replace(",", "")))


def test_every_figure_of_the_summary_is_one_of_the_tables():
    cells = [
        c for row in ROW.findall((ROOT / "docs/benchmarks.md").read_text("utf-8")) for c in row.split("|")[2:]
    ]
    told = numbers("\n".join(cells))
    assert len(told) > 30
    assert told - numbers((ROOT / "benchmarks/results.md").read_text("utf-8")) == set()

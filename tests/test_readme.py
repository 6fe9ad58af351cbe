"""The documentation's examples: commands and Python code print what is shown below them."""

import re
import shlex
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
from bare import bare

ROOT = Path(__file__).resolve().parents[1]
BLOCK = r"((?:(?!```)[^\n]*\n)*)```"  # to its own end, not to that of a later one
PYTHON = re.compile(rf"^```python\n{BLOCK}\n+```text\n{BLOCK}", re.MULTILINE)
NUMBER = re.compile(r"\d+\.?\d*")
LONG = {"diagnose", "predict", "diagnosis"}  # of a command that diagnoses, or goes on with a diagnosis
SLOW = {"--reaction", "configs/design.yaml"}  # thousands of draws, each followed until the robot has stopped
FENCE = re.compile(r"^```console\n(.*?)^```", re.DOTALL | re.MULTILINE)


def documents():
    return [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def shown_commands():
    """Page, command and output of each in a ```console block."""
    for file in documents():
        for block in FENCE.findall(file.read_text("utf-8")):
            for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
                command, _, output = part.replace("\\\n", " ").partition("\n")
                if command.startswith("python -m acf_jax "):
                    name, words = f"{file.name}: {command[:60]}", shlex.split(command)
                    marks = [pytest.mark.long] if (LONG | SLOW) & set(words) else []
                    yield pytest.param(file.name, words, output.rstrip(), id=name, marks=marks)


SHOWN = list(shown_commands())
CODE = [
    pytest.param(*block, id=f"{file.name} {i}")
    for file in documents()
    for i, block in enumerate(PYTHON.findall(file.read_text("utf-8")))
]


def test_the_readme_shows_commands():
    assert any("README" in shown.id for shown in SHOWN) and CODE
    assert any(" diagnose " in shown.id for shown in SHOWN)  # the one that runs as pip alone leaves it


@pytest.fixture(scope="module")
def run_of(tmp_path_factory):
    """What a page's command printed, and its folder: a command goes on with what the one above it left."""

    @cache
    def folder(page):
        made = tmp_path_factory.mktemp("page")
        for name in ("configs", "examples"):
            (made / name).symlink_to(ROOT / name)
        return made

    @cache
    def run(page, command):
        # A diagnosis, the main job, needs nothing that pip does not bring.
        called = bare(*command[3:]) if "diagnose" in command else [sys.executable, *command[1:]]
        finished = subprocess.run(called, cwd=folder(page), capture_output=True, text=True, check=False)
        assert finished.returncode == 0, finished.stderr
        return finished.stdout, folder(page)

    def with_those_above(page, command):
        # the tutorial says the README's commands at length
        place, command = "start.md" if page == "README.md" else page, tuple(command)
        above = [tuple(words) for other, words, _ in (shown.values for shown in SHOWN) if other == page]
        if LONG & set(command):  # the longer checks run by themselves
            for earlier in above[: above.index(command)]:
                run(place, earlier)
        return run(place, command)

    return with_those_above


@pytest.mark.parametrize("page, command, output", SHOWN)
def test_command_prints_what_the_documentation_shows(page, command, output, run_of):
    stdout, folder = run_of(page, command)
    printed, shown = ([line.rstrip() for line in text.rstrip().splitlines()] for text in (stdout, output))
    if shown[-1] == "...":  # further lines, which the page leaves out
        assert len(printed) >= len(shown)
        printed, shown = printed[: len(shown) - 1], shown[:-1]
    if not LONG & set(command):
        assert printed == shown
        return
    assert "diagnose" not in command or (folder / command[-1] / "report.html").exists()
    # What rests on thousands of rounded steps may differ by a unit, or a hundredth, between machines.
    words, numbers = zip(
        *((NUMBER.sub("#", t), NUMBER.findall(t)) for t in map("\n".join, (printed, shown))), strict=True
    )
    assert words[0] == words[1]
    assert [float(x) for x in numbers[0]] == pytest.approx([float(x) for x in numbers[1]], rel=0.01, abs=1)


@pytest.mark.parametrize("code, output", CODE)
def test_code_prints_what_the_documentation_shows(code, output):
    finished = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert finished.returncode == 0, finished.stderr
    assert finished.stdout == output

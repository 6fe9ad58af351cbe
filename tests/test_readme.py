"""The documentation's examples: commands and Python code print what is shown below them."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PYTHON = re.compile(r"^```python\n(.*?)^```\n+```text\n(.*?)^```", re.DOTALL | re.MULTILINE)
FENCE = re.compile(r"^```console\n(.*?)^```", re.DOTALL | re.MULTILINE)


def documents():
    return [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def shown_commands():
    """Command and output of each in a ```console block; a block that starts ```console slow is not run."""
    for file in documents():
        for block in FENCE.findall(file.read_text("utf-8")):
            for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
                command, _, output = part.replace("\\\n", " ").partition("\n")
                if command.startswith("python -m acf_jax "):
                    yield pytest.param(
                        shlex.split(command), output.rstrip(), id=f"{file.name}: {command[:60]}"
                    )


SHOWN = list(shown_commands())
CODE = [
    pytest.param(*block, id=f"{file.name} {i}")
    for file in documents()
    for i, block in enumerate(PYTHON.findall(file.read_text("utf-8")))
]


def test_the_readme_shows_commands():
    assert any("README" in shown.id for shown in SHOWN) and CODE


@pytest.mark.parametrize("command, output", SHOWN)
def test_command_prints_what_the_documentation_shows(command, output, tmp_path):
    arguments = [str(ROOT / a) if (ROOT / a).exists() else a for a in command[1:]]
    finished = subprocess.run(
        [sys.executable, *arguments], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    printed = finished.stdout.rstrip().replace(f"{ROOT}/", "")
    assert finished.returncode == 0, finished.stderr
    assert [line.rstrip() for line in printed.splitlines()] == [line.rstrip() for line in output.splitlines()]


@pytest.mark.parametrize("code, output", CODE)
def test_code_prints_what_the_documentation_shows(code, output):
    finished = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert finished.returncode == 0, finished.stderr
    assert finished.stdout == output

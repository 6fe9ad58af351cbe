"""Run the commands named in a Markdown file and put what they print below them.

    python -m benchmarks.write_docs benchmarks/results.md [--only peak_speed]

A block `<!-- run: COMMAND -->` ... `<!-- end -->` is replaced by the output of COMMAND, run in the
repository's root; everything else stays. Figures in the documentation are so always some run's.
"""

import argparse
import re
import shlex
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BLOCK = re.compile(r"(<!-- run: (?P<command>[^\n]+) -->\n)(?P<output>.*?)(<!-- end -->)", re.DOTALL)


def rewrite(text: str, only: str = "") -> str:
    """`text` with the output of each command whose line contains `only`."""

    def run(block: re.Match[str]) -> str:
        command = shlex.split(block["command"])
        if only not in block["command"]:
            return block[0]
        print(f"running {block['command']}", file=sys.stderr)
        if command[0] == "python":
            command[0] = sys.executable
        finished = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True)
        output = finished.stdout.strip()
        if "|--" not in output:  # no Markdown table
            output = f"```text\n{output}\n```"
        return f"{block[1]}\n{output}\n\n{block[4]}"

    return BLOCK.sub(run, text)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.write_docs", description=__doc__.splitlines()[0]
    )
    parser.add_argument("file", type=Path, nargs="?", default=ROOT / "benchmarks/results.md")
    parser.add_argument("--only", default="", help="run only commands that contain this text")
    options = parser.parse_args(arguments)
    options.file.write_text(rewrite(options.file.read_text("utf-8"), options.only), encoding="utf-8")


if __name__ == "__main__":
    main()

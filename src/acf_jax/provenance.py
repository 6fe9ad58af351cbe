"""Where a result comes from: command, version, date, and what it was made of."""

import hashlib
import json
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from acf_jax import __version__
from acf_jax.files import write_text

FILE = "provenance.json"  # beside a result
PROGRAM = f"acf-jax {__version__}"
MOST = 5  # inputs that a page names
_BLOCK = 1 << 20


def now() -> str:
    """The date and time in UTC, or those of SOURCE_DATE_EPOCH, by which builds are made reproducible."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH", "")
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(int(epoch) if epoch.isdecimal() else None))


@dataclass(frozen=True)
class Origin:
    """How a result came about.

    The date and the command are kept beside a result, never in what a digest or a comparison is taken of.
    """

    command: str
    made_of: Mapping[str, str]  # SHA-256 by the name of the input
    date: str = field(default_factory=now)

    def write(self, folder: Path) -> None:
        """Write provenance.json into a folder."""
        content = {
            "program": PROGRAM,
            "command": self.command,
            "date": self.date,
            "made_of": [{"input": name, "sha256": digest} for name, digest in self.made_of.items()],
        }
        write_text(folder / FILE, json.dumps(content, indent=1) + "\n")

    def __str__(self) -> str:
        named = [f"{name} (SHA-256 {digest[:12]})" for name, digest in self.made_of.items()]
        others = [f"{len(named) - MOST} others in {FILE}"] if len(named) > MOST else []
        inputs = ", ".join([*named[:MOST], *others])
        return f"Made on {self.date[:10]} at {self.date[11:16]} UTC by `{self.command}` of {inputs}."


def digest_of(path: Path) -> str:
    """SHA-256 of a file, or of the names and contents of a folder's files."""
    digest = hashlib.sha256()
    folder = path.is_dir()
    for file in sorted(p for p in path.rglob("*") if p.is_file()) if folder else [path]:
        if folder:
            digest.update(f"{file.relative_to(path).as_posix()}\0{file.stat().st_size}\0".encode())
        with file.open("rb") as stream:
            while block := stream.read(_BLOCK):
                digest.update(block)
    return digest.hexdigest()

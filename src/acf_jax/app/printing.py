"""A report as PDF, printed by a Chromium of this machine that reaches no network."""

import os
import shutil
import subprocess
import tempfile
from contextlib import suppress
from pathlib import Path

from acf_jax.errors import InputError

PROGRAMS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "microsoft-edge")
PATIENCE_S = 120


def pdf_of(page: Path) -> bytes:
    """The PDF of an HTML file; `InputError` where no browser can print it."""
    program = next((path for name in PROGRAMS if (path := shutil.which(name))), None)
    if program is None:
        raise InputError(
            "a PDF needs Chromium, Chrome or Edge on this machine; open the report and print it to a PDF instead"
        )
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "report.pdf"
        command = [
            program, "--headless", "--disable-gpu", "--no-pdf-header-footer", f"--user-data-dir={folder}/profile",
            "--host-resolver-rules=MAP * ~NOTFOUND", "--virtual-time-budget=20000",
            f"--print-to-pdf={out}", page.resolve().as_uri(),
        ]  # fmt: skip
        if os.geteuid() == 0:
            command.insert(1, "--no-sandbox")  # Chromium has none for root
        with suppress(OSError, subprocess.TimeoutExpired):
            subprocess.run(
                command, capture_output=True, timeout=PATIENCE_S, check=False, stdin=subprocess.DEVNULL
            )
        if not out.is_file():
            raise InputError(
                f"{program} did not print the report; open the report and print it to a PDF instead"
            )
        return out.read_bytes()

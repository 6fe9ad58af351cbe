"""Take docs/figures/report.png: the top of the report of examples/session.mcap.

python docs/figures/report.py [REPORT]

REPORT is the report.html of a diagnosis; without it the recording is imported and diagnosed anew. Needs Chromium.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        report = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else make(Path(name))
        from playwright.sync_api import sync_playwright

        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(channel="chromium", executable_path="/usr/bin/chromium")
            page = browser.new_page(viewport={"width": 1100, "height": 900}, color_scheme="light")
            page.goto(report.as_uri())
            page.wait_for_timeout(1500)  # the figures draw themselves
            page.screenshot(path=HERE / "report.png")
            browser.close()


def make(folder: Path) -> Path:
    """The report of the recording, made in `folder`."""
    session, rig = ROOT / "examples/session.mcap", ROOT / "examples/session_rig.yaml"
    for command in (
        ["import", session, "--rig", rig, "--out", "my_rig"],
        ["diagnose", "my_rig", "--out", "diagnosis"],
    ):
        subprocess.run([sys.executable, "-m", "acf_jax", *map(str, command)], cwd=folder, check=True)
    return folder / "diagnosis/report.html"


if __name__ == "__main__":
    main()

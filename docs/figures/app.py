"""Take docs/figures/app_*.png: the app with examples/session.mcap, step by step.

python docs/figures/app.py

Needs `pip install "acf-jax[app]"`, Playwright and Chromium; takes two minutes.
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
RIG = {
    "m": (1.74762, 0.0347509),
    "d": (72.004, 16.7033),
    "k_f": (3.96258, 1.43605),
    "k_c": (112.184, 12.0283),
}
PATIENCE = 300_000  # ms


def main() -> None:
    from playwright.sync_api import expect, sync_playwright

    expect.set_options(timeout=PATIENCE)
    with tempfile.TemporaryDirectory() as name:
        command = [sys.executable, "-m", "acf_jax", "app", name, "--no-browser"]
        app = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert app.stdout is not None
        address = app.stdout.readline().strip()
        try:
            with sync_playwright() as playwright:
                program = shutil.which("chromium") or shutil.which("google-chrome")
                browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
                page = browser.new_page(viewport={"width": 1100, "height": 820}, color_scheme="light")
                page.set_default_timeout(PATIENCE)
                page.goto(address)
                walk(page, expect)
                browser.close()
        finally:
            app.terminate()
            app.wait()


def walk(page: Any, expect: Any) -> None:
    """Every step, and a picture of each."""
    page.set_input_files("#files", ROOT / "examples/session.mcap")
    page.wait_for_url("**/open")
    page.click("[data-preview=force]")
    expect(page.locator("#preview-said")).to_contain_text("samples")
    take(page, "open", 1280)
    page.click("text=Find the contacts")
    drawn(page, expect)
    take(page, "cut", 1250)
    page.click("text=Describe the rig")
    for name, (value, std) in RIG.items():
        page.fill(f"#{name}-value", f"{value}")
        page.fill(f"#{name}-std", f"{std}")
    take(page, "rig", 900)
    page.click("text=Save the rig")
    expect(page.locator("a.first", has_text="Diagnose")).to_be_visible()
    page.click("nav >> text=Plan")
    page.click("text=What would these trials show?")
    expect(page.locator("#answer")).to_be_visible()
    take(page, "plan", 1000)
    page.click("nav >> text=Diagnose")
    page.click("main button.first")
    expect(page.locator("#known-so-far")).to_contain_text("8 explanations weighed so far")
    take(page, "progress", 820)
    drawn(page, expect)
    take(page, "diagnose", 1150)
    page.click("text=Use the corrected model")
    expect(page.locator("#peak-said")).to_contain_text("±")
    page.click("#ask-speed button")
    expect(page.locator("#answer-speed pre")).to_be_visible()
    take(page, "use", 900)


def drawn(page: Any, expect: Any) -> None:
    """The page of a command in its frame."""
    expect(page.frame_locator("iframe.embedded").locator("html[data-drawn]")).to_be_attached()


def take(page: Any, name: str, height: int) -> None:
    """The page, so many pixels of it from the top."""
    page.set_viewport_size({"width": 1100, "height": height})
    page.evaluate("window.scrollTo(0, 0)")
    page.wait_for_timeout(1200)  # figures and frame take their new size
    page.screenshot(path=HERE / f"app_{name}.png")


if __name__ == "__main__":
    main()

"""A slider's change in the app, in Chromium: from the slider's event to the painted curve.

python -m benchmarks.app_sliders

Needs `pip install "acf-jax[app]"`, Playwright and Chromium.
"""

import json
import shutil
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.app_memory import app_in
from benchmarks.machine import describe

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
CHANGES = 100  # of each slider
SLIDERS = {"v_e": "velocity", "f_p": "pretension", "stiffness": "stiffness", "limit": "limit"}
# Each change begins when the one before is painted; the slider goes to and fro over its range. A frame is painted right
# after its animation callbacks: the task that is posted by the first of them comes behind it.
MOVE = """async ([name, changes]) => {
  const sliders = document.getElementById("sliders"), range = document.getElementById(name), took = [];
  const drawn = () => new Promise((resolve) => {
    const seen = new MutationObserver(() => { seen.disconnect(); resolve(); });
    seen.observe(sliders, { attributeFilter: ["data-drawn"] });
  });
  const painted = () => new Promise((resolve) => requestAnimationFrame(() => {
    const channel = new MessageChannel();
    channel.port1.onmessage = resolve;
    channel.port2.postMessage(null);
  }));
  for (let i = 0; i < changes; i++) {
    const [low, high] = [Number(range.min), Number(range.max)];
    range.value = low + (high - low) * (0.3 + 0.4 * ((i * 37) % 100) / 100);
    const begun = performance.now(), done = drawn();
    range.dispatchEvent(new Event("input", { bubbles: true }));
    await done;
    await painted();
    took.push(performance.now() - begun);
  }
  return took;
}"""


def main() -> None:
    from playwright.sync_api import sync_playwright

    print(f"{describe()}\n")
    print(f"| answered by | slider | first change, ms | median | 95 % | worst of {CHANGES} |")
    print("|---|---|--:|--:|--:|--:|")
    with tempfile.TemporaryDirectory() as name, sync_playwright() as playwright:
        home = Path(name)
        for session, learnt in (("simulation", None), ("surrogate", EXAMPLES / "rig_surrogate.eqx")):
            folder = home / session
            (folder / "diagnosis").mkdir(parents=True)
            shutil.copy(EXAMPLES / "rig_model.json", folder / "diagnosis/model.json")
            (folder / "diagnosis/diagnosis.json").write_text(json.dumps({"verdict": "identified"}))
            if learnt is not None:
                (folder / "surrogate").mkdir()
                shutil.copy(learnt, folder / "surrogate/model.eqx")
        program = shutil.which("chromium") or shutil.which("google-chrome")
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        with app_in(home) as app:
            page = browser.new_page(viewport={"width": 1280, "height": 900})
            page.set_default_timeout(300_000)
            page.goto(app.address)
            for session, word in (("simulation", "the simulation"), ("surrogate", "a surrogate")):
                page.goto(f"{app.address.partition('/?')[0]}/s/0/{session}/use")
                page.locator("#sliders[data-drawn]").wait_for(state="attached")
                for slider, called in SLIDERS.items():
                    print(f"| {word} | {called} | {row(page, slider)} |")
        browser.close()


def row(page: Any, slider: str) -> str:
    """The first change, the median, what 95 of 100 stay below, and the worst, ms."""
    took = np.array(page.evaluate(MOVE, [slider, CHANGES]))
    return " | ".join(f"{ms:.0f}" for ms in (took[0], *np.percentile(took, (50, 95)), took.max()))


if __name__ == "__main__":
    main()

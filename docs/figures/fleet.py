"""Draw four rigs at three times, run `fleet` on them, and take docs/figures/fleet.png of its page.

    python -m docs.figures.fleet

needs Chromium and `pip install ".[fleet,test]"`. One rig's friction grows, one gets another pad; the noise is new.
"""

import argparse
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from playwright.sync_api import sync_playwright

from validation.worlds import find_world, make_case, write_data
from validation.worlds.case import record_trials

HERE = Path(__file__).parent
MONTHS = ("april", "may", "june")
RIGS: dict[str, list[dict[str, float]]] = {  # causes and their sizes, month by month
    "deburring-1": [{"coulomb_friction": size} for size in (0.08, 0.13, 0.2)],
    "deburring-2": [{}, {}, {}],
    "sanding-1": [{"gravity": 0.5}] * 3,
    "sanding-2": [{}, {}, {"pad_relaxation": 0.8}],
}


def draw(folder: Path, month: int) -> None:
    """The data sets of all rigs, recorded in one month."""
    world = find_world("scipy")
    for number, (name, history) in enumerate(RIGS.items()):
        case = make_case(40 + number, coloured=False)
        causes = [world.draw(cause, number, case.setup.rig, size) for cause, size in history[month].items()]
        trials = record_trials(np.random.default_rng([number, month]), world, case.setup, causes)
        write_data(replace(case, trials=trials), folder / name)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--work", type=Path, default=Path("artifacts/fleet"), help="data sets and results")
    options = parser.parse_args()
    done: list[str] = []
    for month, name in enumerate(MONTHS):
        if not (options.work / "data" / name).exists():
            draw(options.work / "data" / name, month)
        command = [sys.executable, "-m", "acf_jax", "fleet", str(options.work / "data" / name)]
        command += ["--out", str(options.work / name)]
        for earlier in done:
            command += ["--since", str(options.work / earlier)]
        print("$", " ".join(["python", *command[1:]]), flush=True)
        subprocess.run(command, check=True)
        done.append(name)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1120, "height": 1400})
        page.goto((options.work / done[-1] / "index.html").absolute().as_uri())
        page.wait_for_selector("html[data-drawn]")
        page.screenshot(path=HERE / "fleet.png", full_page=True)
        browser.close()


if __name__ == "__main__":
    main()

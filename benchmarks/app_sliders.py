"""A slider's change in the app: from the request to the answer with the whole curve, by simulation and by surrogate.

python -m benchmarks.app_sliders
"""

import json
import shutil
import tempfile
import time
from pathlib import Path
from urllib.parse import urlencode

import numpy as np

from benchmarks.app_memory import App, app_in
from benchmarks.machine import describe

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
CHANGES = 200


def main() -> None:
    print(f"{describe()}\n")
    print("| answered by | first, s | ms, median | ms, 99 % below |")
    print("|---|--:|--:|--:|")
    with tempfile.TemporaryDirectory() as name:
        home = Path(name)
        for session, learnt in (("simulation", None), ("surrogate", EXAMPLES / "rig_surrogate.eqx")):
            folder = home / session
            (folder / "diagnosis").mkdir(parents=True)
            shutil.copy(EXAMPLES / "rig_model.json", folder / "diagnosis/model.json")
            (folder / "diagnosis/diagnosis.json").write_text(json.dumps({"verdict": "identified"}))
            if learnt is not None:
                (folder / "surrogate").mkdir()
                (folder / "surrogate/model.eqx").write_bytes(learnt.read_bytes())  # younger than the model
        with app_in(home) as app:
            for session, word in (("simulation", "the simulation"), ("surrogate", "a surrogate")):
                first = timed(app, session, 0)
                times = 1e3 * np.array([timed(app, session, i) for i in range(1, CHANGES)])
                print(f"| {word} | {first:.1f} | {np.median(times):.1f} | {np.quantile(times, 0.99):.1f} |")


def timed(app: App, session: str, i: int) -> float:
    """One change, s: another velocity, pretension and stiffness each time."""
    at = {"v_e": 0.1 + 0.0005 * i, "f_p": 55 + 0.1 * i, "stiffness": 1.0 + 0.0002 * (i % 10), "limit": 140}
    begin = time.perf_counter()
    found = json.loads(app.ask("GET", f"/s/0/{session}/curve?{urlencode(at)}"))
    spent = time.perf_counter() - begin
    assert found["at"]["force"] is not None
    return spent


if __name__ == "__main__":
    main()

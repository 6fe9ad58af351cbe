"""What is learnt from simulated rigs, with where it comes from: `calibration.json`."""

import json
from importlib.resources import files
from typing import Any

CALIBRATION = "calibration.json"


def read_calibration() -> dict[str, Any]:
    """The file that the package comes with: `learnt`, and the command, runs and commit behind it."""
    content: dict[str, Any] = json.loads(
        files("acf_jax.evidence").joinpath(CALIBRATION).read_text(encoding="utf-8")
    )
    return content


# degrees of freedom of the mean square that is left of a gap on other conditions
ELSEWHERE: float = read_calibration()["learnt"]["elsewhere"]

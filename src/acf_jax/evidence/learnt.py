"""The numbers of the posterior that are learnt from simulated rigs, with where they come from: `calibration.json`."""

import json
from importlib.resources import files
from typing import Any, NamedTuple

CALIBRATION = "calibration.json"


class Learnt(NamedTuple):
    """What `python -m validation.calibrate` learns."""

    temperature: float  # by which log evidence is divided: it is surer than it is right
    effect: float  # cost of each law, in log probability
    free_curve: float  # cost of a free curve, or of any other unknown cause
    elsewhere: float  # degrees of freedom of the mean square that is left of a gap on other conditions


def read_calibration() -> dict[str, Any]:
    """The file that the package comes with: `learnt`, and the command, runs and commit behind it."""
    content: dict[str, Any] = json.loads(
        files("acf_jax.evidence").joinpath(CALIBRATION).read_text(encoding="utf-8")
    )
    return content


LEARNT = Learnt(**read_calibration()["learnt"])

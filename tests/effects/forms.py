"""What every law does to one impact, as it was when its `form` began.

python -m tests.effects.forms records laws and forms that are new; those that are there stay as they are.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

from acf_jax.inference.parameters import every_effect
from tests.effects.contract import LONG, Kind, run, start

RECORDED = Path(__file__).with_name("forms.json")
AT = [2, 8, 20, 40, 64, 128, 255]  # samples, before and after contact is lost


def recorded() -> dict[str, dict[str, Any]]:
    """Of each law by name: the form, parameters in SI units, and sensed and contact force in N."""
    found: dict[str, dict[str, Any]] = json.loads(RECORDED.read_text()) if RECORDED.exists() else {}
    return found


def forces_of(kind: Kind, theta: list[float]) -> np.ndarray:
    """(2, samples) N."""
    response = run(kind, [theta], h=LONG)
    return np.stack([response.sensed[0, AT], response.contact[0, AT]])


def main() -> None:
    known = recorded()
    for name, kind in every_effect().items():
        if name not in known or known[name]["form"] != kind.form:
            theta = start(kind, -1).tolist()
            known[name] = {"form": kind.form, "theta": theta, "force_n": forces_of(kind, theta).tolist()}
    RECORDED.write_text(json.dumps(known, indent=1) + "\n")


if __name__ == "__main__":
    from acf_jax.start import start_jax

    start_jax()
    main()

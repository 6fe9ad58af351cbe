"""How fast may the flange meet a wall? By the paper's model, refitted, corrected, learnt - and in truth.

    python -m docs.examples.closed_loop [--model artifacts/closed_loop/model.eqx]

The truth is that of the simulated rig behind examples/rig, an engine that shares no code with the models.
"""

# %% Set-up: double precision, and the surrogate, which carries the corrected model that it was trained on.
import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import jax
import numpy as np
import yaml
from scipy.optimize import brentq

from acf_jax.contact.body import WALL
from acf_jax.contact.model import ContactModel, forces
from acf_jax.contact.read import by_surrogate, of_diagnosis
from acf_jax.gap_model import check_model
from acf_jax.surrogate import load_corrected
from validation.worlds.interface import Impact, Rig, find_world

ROOT = Path(__file__).resolve().parents[2]
F_P = 60.0  # N
LIMITS = (90.0, 120.0, 150.0)  # N, of the peak contact force
RANGE = (0.05, 0.35)  # m/s, of the trials

parser = argparse.ArgumentParser(description="Allowed speeds by every model of examples/rig.")
parser.add_argument("--model", type=Path, default=ROOT / "examples/rig_surrogate.eqx", help="a model.eqx")
options = parser.parse_args()
jax.config.update("jax_enable_x64", True)
surrogate, content = load_corrected(options.model)
gap = check_model(options.model, content)

# %% The models: one function from contact velocity to peak contact force each.
Force = Callable[[float], float]


def of(model: ContactModel) -> Force:
    """Peak contact force against a wall, N."""
    return lambda v: float(forces(model.main.peak, model.at(v, F_P)[None], WALL)[0][0])


answer = yaml.safe_load((ROOT / "examples/rig_answer.yaml").read_text("utf-8"))
world, rig = find_world(answer["world"]), Rig(*answer["rig"].values())
drawn = world.draw("end_stop", answer["seed"], rig, answer["sizes"]["end_stop"])
stop = replace(drawn, **answer["parameters"]["end_stop"])  # type: ignore[type-var]
time = np.linspace(0.0, 0.02, 2001)  # s


def truth(v: float) -> float:
    """The largest contact force of the rig itself, N."""
    response = world.respond(rig, [stop], Impact(v, F_P), time)
    return float(response.contact.max())


corrected = of_diagnosis(gap)
models: dict[str, Force] = {
    "paper's model": of(of_diagnosis(gap, which="nominal")),
    "recalibrated": of(of_diagnosis(gap, which="recalibrated")),
    "corrected": of(corrected),
    "surrogate": of(by_surrogate(corrected, surrogate)),
    "truth": truth,
}

# %% The speed at which the expected force reaches each limit.
speeds = {
    name: [
        brentq(lambda v, limit=limit, force=force: force(v) - limit, *RANGE, xtol=1e-6) for limit in LIMITS
    ]
    for name, force in models.items()
}
print(f"speed in m/s at which the peak contact force reaches a limit, {F_P:g} N of pretension")
print(f"{'':14}" + "".join(f"{limit:9.0f} N" for limit in LIMITS))
for name, row in speeds.items():
    print(f"{name:14}" + "".join(f"{v:11.4f}" for v in row))

"""Work that a test sends to other processes; they import it by name. It stands for a diagnosis and takes no time."""

import json
import os
import signal
import time
from pathlib import Path

import numpy as np

from acf_jax.fleet.run import Files, Task

KILLED = "killed.txt"  # beside the data set at which a process was killed once: which process


def weigh(task: Task) -> Files:
    """What a diagnosis leaves, with the mean of all forces for the moving mass."""
    dataset, seed = task
    mean = float(np.mean([trial.trace.force.mean() for trial in dataset.trials if trial.trace]))
    error = {"force_rms_n": 1.0, "peak_rms_percent": 1.0}
    content = {
        "verdict": "no_gap",
        "explanations": [{"effects": [], "probability": 0.9}],
        "credible_set": [[]],
        "where": {"component": {"actuator": 0.1}},
        "gap": {"recalibrated": error, "corrected": error},
        "shrinkage": {"force": None, "peak": None},
        "parameters": {"moving_mass_kg": {"value": mean, "std": 1.0, "unit": "kg", "at_bound": False}},
        "warnings": [f"seed {seed}"],
    }
    written = {"diagnosis.json": json.dumps(content), "model.json": "{}", "report.html": dataset.folder.name}
    return {name: text.encode() for name, text in written.items()}


def weigh_or_die(task: Task) -> Files:
    """The same; the process is killed in the middle of the rig b, the first time."""
    files = weigh(task)
    marker = Path(task[0].folder) / KILLED
    if marker.parent.name == "b" and not marker.exists():
        marker.write_text(str(os.getpid()))
        os.kill(os.getpid(), signal.SIGKILL)
    return files


def process_after(seconds: float) -> int:
    """The process that waited so long."""
    time.sleep(seconds)
    return os.getpid()


def refuse(task: Task) -> Files:
    raise RuntimeError("was asked to diagnose")

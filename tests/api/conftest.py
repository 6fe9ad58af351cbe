"""One recording with sign and offset of its own, and one small diagnosis of it, that the tests share."""

from pathlib import Path

import numpy as np
import pytest

import acf_jax as acf
from tests.few import few_explanations
from tests.recording.sessions import columns, made

KNOWN = {"m": (2.1, 0.04), "d": (60.0, 18.0), "k_f": (800.0, 500.0), "k_c": (3.4e5, 4e4)}
SIGNALS = {"force": "-1*Fz", "velocity": "0.001*v_mm_s", "pretension": "preload", "time": "t", "tare": True}


@pytest.fixture(scope="session")
def press(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A table whose force is negative in contact and never tared, its velocity in mm/s; twelve impacts."""
    session = columns(made())
    table = np.stack(
        [
            session["time_s"],
            -(session["force_n"] + 7.0),
            1e3 * session["velocity_m_per_s"],
            session["pretension_n"],
        ],
        axis=1,
    )
    path = tmp_path_factory.mktemp("press") / "press.csv"
    np.savetxt(path, table, "%.6f", ",", header="t,Fz,v_mm_s,preload", comments="")
    return path


@pytest.fixture(scope="session")
def recording(press: Path):
    return acf.read_recording(press, **SIGNALS)


@pytest.fixture(scope="session")
def diagnosed(press: Path):
    """The diagnosis of the recording without one trial, by few of the library's effects."""
    session = acf.read_recording(press, **SIGNALS)
    session.drop("t011")
    with few_explanations(("gravity", "sensor_lag"), ("unknown_actuator",)):
        return acf.diagnose(session, rig=acf.Prior(**KNOWN))

"""One small diagnosis with a trimmed library: compiled programs are the cost of these tests, so they share it."""

import pytest

from acf_jax.dataset import GapDataset, read_dataset
from acf_jax.diagnosis import Diagnosis, diagnose
from tests.few import few_explanations
from validation.worlds import make_case, write_case

KEPT = ("gravity", "pad_relaxation", "sensor_scale")
CURVES = ("unknown_actuator", "unknown_sensor")


@pytest.fixture(scope="session")
def gravity_set(tmp_path_factory: pytest.TempPathFactory) -> GapDataset:
    """Impacts of a rig with a constant force on the flange that the paper leaves out, from the scipy world."""
    folder = tmp_path_factory.mktemp("gravity") / "set"
    write_case(make_case(11, ["gravity"], target=40.0, coloured=False), folder)
    return read_dataset(folder)


@pytest.fixture(scope="session")
def diagnosed(gravity_set: GapDataset) -> Diagnosis:
    """The diagnosis of that set with three of the effects and two of the free curves."""
    with few_explanations(KEPT, CURVES):
        return diagnose(gravity_set)

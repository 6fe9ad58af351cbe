"""Small diagnoses with a trimmed library, whose names and texts try to break out of the page."""

from dataclasses import replace

import pytest

from acf_jax.dataset import GapDataset, read_dataset
from acf_jax.diagnosis import Diagnosis, diagnose
from acf_jax.evidence.posterior import UNKNOWN, Scored
from tests.few import few_explanations
from validation.worlds import make_case, write_case

KEPT = ("coulomb_friction", "sensor_lag")
EVIL = "</script><img src=x onerror=\"document.title='owned'\">"


def diagnose_with_few(dataset: GapDataset) -> Diagnosis:
    """Two effects and one free curve in place of the whole library: compiled programs are what costs time."""
    with few_explanations(KEPT, ("unknown_actuator",)):
        return diagnose(dataset)


@pytest.fixture(scope="session")
def evil_set(tmp_path_factory: pytest.TempPathFactory) -> GapDataset:
    """A rig with dry friction, from the scipy world, with texts that are HTML."""
    folder = tmp_path_factory.mktemp("report") / "set"
    write_case(make_case(7, ["coulomb_friction"], target=30.0, coloured=False), folder)
    dataset = read_dataset(folder)
    trials = [replace(t, name=f"{t.name}{EVIL}") for t in dataset.trials[::3]]
    return replace(dataset, description=f"a <b>rig</b> {EVIL}", trials=tuple(trials))


@pytest.fixture(scope="session")
def diagnosed(evil_set: GapDataset) -> Diagnosis:
    """The diagnosis of that set, one trial said to be left out."""
    diagnosis = diagnose_with_few(evil_set)
    warnings = (*diagnosis.warnings, f"a warning about {EVIL}")
    return replace(diagnosis, excluded={evil_set.trials[0].name: f"a reason {EVIL}"}, warnings=warnings)


@pytest.fixture(scope="session")
def peaks_only(evil_set: GapDataset) -> Diagnosis:
    """The diagnosis of the same peaks without their traces."""
    return diagnose_with_few(replace(evil_set, trials=tuple(replace(t, trace=None) for t in evil_set.trials)))


@pytest.fixture(scope="session")
def unknown(diagnosed: Diagnosis) -> Diagnosis:
    """The same diagnosis, had the free discrepancy at the actuator been the most probable explanation."""
    d = diagnosed
    curve = next(f for f in d.fits if f.explanation == ("unknown_actuator",))
    probability = tuple(0.98 if f is curve else 0.02 / (len(d.fits) - 1) for f in d.fits)
    told = diagnosed.told._replace(scored=(Scored(UNKNOWN, 0.98), Scored((), 0.02)))
    changes = {"told": told, "credible": (UNKNOWN,), "corrected": curve, "indistinguishable": ()}
    return replace(d, verdict="unknown", probability=probability, **changes)

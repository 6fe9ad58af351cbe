"""Effects fitted to data of an independent world: the right one fits best, and its size is right."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from acf_jax.dataset import assess_dataset, read_dataset
from acf_jax.diagnosis.candidates import fit_nominal, fit_single
from acf_jax.inference.baseline import Ground
from acf_jax.inference.fit import Fit
from acf_jax.inference.observations import observe
from acf_jax.inference.scatter import with_scatter
from validation.worlds import make_case, write_data


def fitted(folder: Path, seed: int, name: str, rival: str, distance: float = 40.0) -> tuple[Any, Fit, Fit]:
    """The hidden cause, the fit of its effect and that of another effect much like it."""
    case = make_case(seed, [name], target=distance, coloured=False)
    write_data(case, folder / "set")
    observations = with_scatter(observe(assess_dataset(read_dataset(folder / "set"))))
    ground = Ground.of(observations, fit_nominal(observations))
    return case.causes[name], fit_single(ground, name), fit_single(ground, rival)


@pytest.mark.parametrize("seed", [2, pytest.param(3, marks=pytest.mark.long)])
def test_where_a_pad_bottoms_out_is_found(tmp_path: Path, seed: int) -> None:
    truth, found, hardening = fitted(tmp_path, seed, "pad_bottoming", "contact_hardening")
    ratio, compression = found.physical[4:]
    assert truth.compression < compression < 1.1 * (truth.compression + truth.width / 2)
    assert ratio * found.physical[3] == pytest.approx(truth.stiffness, rel=0.2)
    assert found.objective < hardening.objective - 20


@pytest.mark.parametrize("seed", [2, 3])  # an offset and a share
def test_a_wrong_pretension_is_told_from_a_wrong_gain(tmp_path: Path, seed: int) -> None:
    truth, found, gain = fitted(tmp_path, seed, "pretension_error", "sensor_scale")
    share, offset, _ = found.physical[4:]
    commanded = np.array([60.0, 100.0])
    right = truth.share * commanded + truth.offset
    assert share * commanded + offset == pytest.approx(right, abs=0.5)
    assert found.objective < gain.objective - 5


@pytest.mark.parametrize(
    "seed", [pytest.param(4, marks=pytest.mark.long), 5]
)  # where a third of the friction grows with the pretension
def test_friction_that_grows_with_pressure_is_found_at_every_pretension(tmp_path: Path, seed: int) -> None:
    truth, found, gravity = fitted(tmp_path, seed, "coulomb_friction", "gravity", 280.0)
    constant, coefficient, _ = found.physical[4:]
    pretension = np.array([40.0, 120.0])
    right = truth.force_n * (1 + truth.pressed * (pretension / 80 - 1))
    assert np.diff(right) > 10
    assert constant + coefficient * pretension == pytest.approx(right, rel=0.02)
    assert found.objective < gravity.objective - 1000


@pytest.mark.long
def test_a_plate_on_the_sensor_is_told_from_a_mode_that_a_part_of_the_force_passes(tmp_path: Path) -> None:
    truth, plate, mode = fitted(tmp_path, 2, "fixture_mass", "sensor_resonance", 600.0)
    mass, stiffness, damping_time = plate.physical[4:]
    assert mass / stiffness == pytest.approx(
        truth.mass / truth.stiffness, rel=0.01
    )  # its ring; the rest is the prior
    assert damping_time == pytest.approx(truth.damping / truth.stiffness, rel=0.1)
    assert plate.objective < mode.objective - 5
    truth, mode, plate = fitted(tmp_path / "other", 2, "sensor_resonance", "fixture_mass", 600.0)
    assert mode.physical[[4, 6]] == pytest.approx([truth.share, truth.frequency], rel=0.03)
    assert mode.objective < plate.objective - 1000

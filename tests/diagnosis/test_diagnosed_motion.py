"""What a fit infers of the robot's motion, what that changes, and the picture of it."""

import json
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from acf_jax.diagnosis import diagnose
from acf_jax.diagnosis.candidates import fit_nominal
from acf_jax.diagnosis.experiment import propose
from acf_jax.diagnosis.motion import inferred_motion, statement
from acf_jax.inference.fit import fit
from acf_jax.inference.parameters import begin
from acf_jax.provenance import Origin
from acf_jax.report.motion import robot_motion
from acf_jax.report.write import save_diagnosis
from tests.few import few_explanations
from tests.imagined import RIG
from tests.inference.test_robot_motion import STD, V_E, braked, observed, trials


def test_the_inferred_motion_is_the_true_one_within_its_error() -> None:
    o = observed(trials(STD, noise=0.05))
    fitted = fit_nominal(o)
    time, velocity = inferred_motion(o, fitted)
    inside = time < 0.006
    true = np.array([braked(time[inside], v) for v in V_E])
    assert np.sqrt(((velocity[:, inside] - true) ** 2).mean()) < 2 * STD
    path = (velocity[:, inside] - true).cumsum(1) * fitted.grid.h
    commanded = (V_E[:, None] - true).cumsum(1) * fitted.grid.h
    assert np.abs(path).max() < 0.1 * np.abs(commanded).max()


def test_effects_add_to_the_measured_motion() -> None:
    o = observed(trials(STD))
    stiff = fit(o, (), begin(RIG.values), iterations=0)
    soft = fit(o, ("robot_compliance",), begin(RIG.values, [0.1, 20.0, 0.1]), iterations=0)
    (time, there), (_, here) = (inferred_motion(o, f) for f in (stiff, soft))
    added = here[:, time.size // 2] - there[:, time.size // 2]
    assert (added < -0.005).all()  # what is pressed yields
    assert here[:, 0] == pytest.approx(there[:, 0])


def test_by_how_much_it_changes_the_force_is_said() -> None:
    o = observed(trials(STD))
    nominal = fit(o, (), begin(RIG.values), iterations=0)
    found = re.search(r"changes the recalibrated model's force by ([\d.]+) N RMS", statement(o, nominal))
    assert found
    # against forces of the same rig whose robot kept its speed, which miss these by as much
    still = fit(replace(o, robot=None), (), begin(RIG.values), iterations=0)
    missed = np.sqrt(((o.force - still.linearised().predicted)[o.used] ** 2).mean())
    assert float(found[1]) == pytest.approx(missed, rel=0.1)
    assert statement(replace(o, robot=None), nominal) == ""
    steady = o.robot._replace(velocity=1e-4 * o.robot.velocity)
    assert statement(replace(o, robot=steady), nominal) == ""


@pytest.mark.long
def test_a_diagnosis_of_measured_motions_has_their_picture_and_a_warning(tmp_path: Path) -> None:
    with few_explanations(("gravity",), ("unknown_robot",)):
        found = diagnose(trials(STD))
    assert found.scored[0].explanation == ()
    assert any("the robot did not keep its commanded speed" in warning for warning in found.warnings)
    save_diagnosis(tmp_path / "out", found, Origin("diagnose", {}))
    page = (tmp_path / "out/report.html").read_text()
    assert 'id="motion-data"' in page and "The robot moves as measured" in page


def test_a_next_trial_is_proposed_for_a_robot_that_keeps_its_speed() -> None:
    o = observed(trials(STD))
    fits = [
        fit(o, ("gravity",), begin(RIG.values, [20.0]), iterations=0),
        fit(o, ("coulomb_friction",), begin(RIG.values, [5.0, 0.0, 0.01]), iterations=0),
    ]
    found = propose(o, (fits[0], 0.6), (fits[1], 0.4))
    assert found is not None and found.error_after < found.error_before == pytest.approx(0.4)
    otherwise = replace(o, robot=o.robot._replace(velocity=2 * o.robot.velocity))
    assert propose(otherwise, (fits[0], 0.6), (fits[1], 0.4)) == found


def test_the_report_shows_commanded_measured_and_inferred_velocity() -> None:
    dataset = trials(STD)
    dataset = replace(dataset, trials=(*dataset.trials[:3], replace(dataset.trials[3], motion=None)))
    o = observed(dataset)
    fitted = fit(o, (), begin(RIG.values), iterations=0)
    made = SimpleNamespace(dataset=dataset, observations=o, corrected=fitted)
    figure = robot_motion(made)
    assert figure is not None
    content = json.loads(re.search(r'id="motion-data">(.*?)</script>', figure)[1])
    assert len(content["variants"]) == 3  # with a motion
    last = content["variants"][2]["data"]
    assert [trace["name"] for trace in last] == ["commanded", "measured", "inferred"]
    commanded, measured, inferred = last
    assert commanded["y"] == [0.3, 0.3]
    assert measured["y"][-1] < 0.26
    assert inferred["x"][0] == 0.0
    assert inferred["y"] == pytest.approx(braked(1e-3 * np.array(inferred["x"]), 0.3), abs=4 * STD)
    without = SimpleNamespace(dataset=dataset, observations=replace(o, robot=None), corrected=fitted)
    assert robot_motion(without) is None

"""Answers, as worlds write them and as a colleague may."""

import json

import pytest

from acf_jax.errors import InputError
from validation.blind.answer import DIAGNOSIS, check_answer, read_said

LIFELIKE = {
    "effects": ["contact_hardening", "sensor_resonance"],
    "background": {"robot_deceleration": 0.0118, "sensor_scale": 0.0037},
    "ring_of_each_trial": False,
    "components": ["contact", "sensor"],
    "noise": "white",
    "held_out_peak_force_n": {"h000": 93.131},
}


def damped(ratio, **changed):
    modes = {"sensor_resonance": {"damping_ratio": ratio, "frequency": 400.0, "shares": [0.1, 0.2]}}
    return check_answer("a", {**LIFELIKE, **changed, "parameters": modes})


def test_small_effects_and_their_shares_are_read():
    answer = check_answer("a", LIFELIKE)
    assert answer.background == {"robot_deceleration": 0.0118, "sensor_scale": 0.0037}
    assert answer.effects == ("contact_hardening", "sensor_resonance")


@pytest.mark.parametrize(("ratio", "name"), [(0.02, "sensor_resonance"), (1.0, "sensor_lag")])
def test_a_strongly_damped_resonance_is_a_lag(ratio, name):
    assert damped(ratio).effects == ("contact_hardening", name)
    small = damped(ratio, effects=["gravity"], background={"sensor_resonance": 0.004, "pad_mass": 0.01})
    assert small.background == {name: 0.004, "pad_mass": 0.01} and small.effects == ("gravity",)


def test_a_strongly_damped_resonance_beside_a_lag_is_one_effect():
    assert damped(2.0, effects=["sensor_lag", "sensor_resonance"]).effects == ("sensor_lag",)
    small = damped(2.0, effects=["sensor_lag"], background={"sensor_resonance": 0.01, "gravity": 0.005})
    assert small.effects == ("sensor_lag",) and small.background == {"gravity": 0.005}


@pytest.mark.parametrize(
    ("changed", "fault"),
    [
        ({"background": {"gravty": 0.01}}, "background: 'gravty' is none of"),
        ({"background": {"gravity": "much"}}, "background.gravity"),
        ({"parameters": {"sensor_resonance": {"damping_ratio": "high"}}}, "sensor_resonance.damping_ratio"),
    ],
)
def test_what_is_wrong_in_an_answer_is_named(changed, fault):
    with pytest.raises(InputError, match=fault):
        check_answer("a", {"effects": [], **changed})


def test_a_diagnosis_whose_gap_is_not_shared_out_whole_is_refused(tmp_path):
    share = {"value": 1.0, "ci95": [0.9, 1.0]}
    content = {
        "verdict": "identified",
        "explanations": [{"effects": ["gravity"], "probability": 0.99}],
        "credible_set": [["gravity"]],
        "indistinguishable": [],
        "where": {"component": {"actuator": 1.0}},
        "shrinkage": {"force": None},
        "contributions": [{"effect": "gravity", "force_share": share}],
        "parameters": {},
        "excluded_trials": [],
    }
    (tmp_path / DIAGNOSIS).write_text(json.dumps(content))
    with pytest.raises(
        InputError, match="contributions: has no part called background nor scatter; remove its"
    ):
        read_said(tmp_path)
    content["contributions"] += [{"effect": name, "force_share": share} for name in ("background", "scatter")]
    (tmp_path / DIAGNOSIS).write_text(json.dumps(content))
    assert len(read_said(tmp_path).contributions) == 3

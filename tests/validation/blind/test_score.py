"""Held-out forces against predictions."""

import numpy as np

from validation.blind.answer import Said
from validation.blind.score import _explained, force_at


def test_a_predicted_force_ends_with_its_trace_and_no_rounding_before() -> None:
    times = np.arange(1, 601) * 1e-4
    predicted_at = np.arange(601) / 1e4 * (1 - 1e-14)  # the rate of a trace is known within rounding
    force = 100 + 1e3 * predicted_at
    np.testing.assert_allclose(force_at(times, predicted_at, force), 100 + 1e3 * times, rtol=1e-6)
    beyond = force_at(np.array([0.0601]), predicted_at, force)
    assert beyond == 0


def test_a_class_holds_explanations_by_as_many_effects() -> None:
    """What one of two confused effects explains is not the pair of both."""
    said = Said.model_validate(
        {
            "verdict": "ambiguous",
            "explanations": [{"effects": ["gravity"], "probability": 0.9}],
            "credible_set": [["gravity"]],
            "indistinguishable": [{"effects": ["coulomb_friction", "gravity"]}],
            "where": {"component": {"actuator": 1.0}},
            "shrinkage": {"force": None},
            "parameters": {},
            "excluded_trials": [],
        }
    )
    assert _explained(said, ["coulomb_friction"], {})["first_in_class"]
    pair = _explained(said, ["coulomb_friction", "gravity"], {})
    assert not pair["first_in_class"] and not pair["covered_in_class"] and pair["one_right"]

"""Held-out forces against predictions, and explanations against the truth."""

from pathlib import Path

import numpy as np
import pytest

from validation.blind.answer import Answer, Failed, Said
from validation.blind.score import _unexplained, explained, force_at, score_one

LARGE, SMALL = ["contact_hardening", "sensor_lag"], ["gravity", "pad_mass"]


def said(effects: list[str], twins: list[list[str]] | None = None, probability: float = 0.9) -> Said:
    """A diagnosis that names these effects first, and an end stop next."""
    return Said.model_validate(
        {
            "verdict": "ambiguous",
            "explanations": [
                {"effects": effects, "probability": probability},
                {"effects": ["end_stop"], "probability": 1 - probability},
            ],
            "credible_set": [effects],
            "indistinguishable": [{"effects": pair} for pair in twins or []],
            "where": {"component": {"actuator": 1.0}},
            "shrinkage": {"force": None},
            "parameters": {},
            "excluded_trials": [],
        }
    )


def test_a_predicted_force_ends_with_its_trace_and_no_rounding_before() -> None:
    times = np.arange(1, 601) * 1e-4
    predicted_at = np.arange(601) / 1e4 * (1 - 1e-14)  # the rate of a trace is known within rounding
    force = 100 + 1e3 * predicted_at
    np.testing.assert_allclose(force_at(times, predicted_at, force), 100 + 1e3 * times, rtol=1e-6)
    beyond = force_at(np.array([0.0601]), predicted_at, force)
    assert beyond == 0


def test_a_class_holds_explanations_by_as_many_effects() -> None:
    """What one of two confused effects explains is not the pair of both."""
    confused = said(["gravity"], [["coulomb_friction", "gravity"]])
    assert explained(confused, ["coulomb_friction"], {})["first_in_class"]
    pair = explained(confused, ["coulomb_friction", "gravity"], {})
    assert not pair["first_in_class"] and not pair["covered_in_class"] and pair["one_right"]


@pytest.mark.parametrize(
    ("named", "truth", "right"),
    [
        (LARGE, LARGE, True),
        ([*LARGE, "gravity"], LARGE, True),
        (["sensor_lag"], LARGE, False),
        (["gravity", "sensor_lag"], LARGE, False),
        ([*LARGE, "end_stop"], LARGE, False),
        (["unknown"], LARGE, False),
        ([], [], True),
        (["pad_mass"], [], True),
        (["end_stop"], [], False),
        (["unknown"], [], False),
        (["unknown"], ["unknown"], True),
        (["gravity"], ["unknown"], False),
        ([], ["unknown"], False),
    ],
)
def test_among_small_effects_all_large_ones_are_named_and_none_that_is_not_there(named, truth, right) -> None:
    found = explained(said(named), truth, {}, SMALL)
    assert found["first_right"] is found["first_in_class"] is found["covered"] is right
    assert found["probability_truth"] == pytest.approx(0.9 if right else 0.0)


def test_a_small_effect_need_not_be_named_and_is_none_where_there_is_no_background() -> None:
    assert not explained(said(["gravity"]), [], {})["first_right"]
    confused = said(["pad_relaxation"], [["contact_damping", "pad_relaxation"]])
    found = explained(confused, ["contact_damping"], {}, SMALL)
    assert found["first_in_class"] and not found["first_right"]


@pytest.mark.parametrize(
    ("answer", "truth", "components"),
    [
        (Answer(effects=("sensor_lag",), background={"gravity": 0.01}), ["sensor_lag"], ["sensor"]),
        (Answer(effects=(), background={"gravity": 0.01}), [], []),
        (
            Answer(effects=("loose_pad",), background={"gravity": 0.01}, components=("contact",)),
            ["unknown"],
            ["contact"],
        ),
    ],
)
def test_a_set_with_a_background_is_lifelike(answer, truth, components) -> None:
    row = score_one(Path("a"), Path("b"), Failed(error="no trials"), answer)
    assert (row["kind"], row["truth"], row["components"]) == ("lifelike", truth, components)
    assert row["background"] == ["gravity"]


def test_what_is_said_to_be_no_laws_is_scored_where_a_law_is_named() -> None:
    def part(effect: str, value: float) -> dict[str, object]:
        return {"effect": effect, "force_share": {"value": value, "ci95": [value - 0.1, value + 0.1]}}

    rest = [part("background", 0.3), part("scatter", 0.1)]
    named, unknown = (
        Said.model_validate(said(["gravity"]).model_dump() | {"contributions": parts})
        for parts in ([part("gravity", 0.6), *rest], rest)
    )
    found = _unexplained(named)
    assert found and found["scatter"] == 0.1 and found["ci95"] == pytest.approx([0.2, 0.4])
    assert _unexplained(unknown) is None and _unexplained(said(["gravity"])) is None

"""The figures of a score."""

from validation.blind.page import score_page
from validation.blind.summary import summarise
from validation.blind.table import lines

NONE = {
    "set": "a",
    "kind": "none",
    "causes": [],
    "truth": [],
    "components": [],
    "distance": 0.0,
    "world": "scipy",
    "clear": False,
    "verdict": "no_gap",
    "first": [],
    "probability_first": 0.9,
    "probability_truth": 0.9,
    "credible": [[]],
    "first_right": True,
    "first_in_class": True,
    "covered": True,
    "component_right": False,
    "rig_error": {},
}
ALARM = NONE | {"set": "b", "verdict": "ambiguous", "first": ["gravity"], "first_right": False}
ALARM |= {"first_in_class": False}
ERROR = {key: NONE[key] for key in ("kind", "causes", "truth", "components", "distance", "world", "clear")}
ERROR |= {"set": "c", "verdict": "error", "error": "no trials"}


def test_the_one_number_counts_every_data_set_and_an_unusable_one_as_wrong() -> None:
    rows = [NONE, ALARM, ERROR]
    score = summarise(rows)
    assert (score["first"]["right"], score["first"]["n"]) == (1, 3)
    assert score["none"]["false_alarms"]["right"] == 2
    assert "first answers that are right: 1/3" in lines(rows, score)
    assert "1 of 3 first answers are right" in str(score_page("rig", rows, score))

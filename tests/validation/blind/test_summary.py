"""The figures of a score."""

import pytest

from validation.blind.page import score_page
from validation.blind.summary import summarise
from validation.blind.table import lines
from validation.blind.targets import targets

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
LIFELIKE = NONE | {"kind": "lifelike", "background": ["gravity", "pad_mass"], "distance": 90.0, "ratio": 0.4}
LIFELIKE |= {"verdict": "identified", "shrinkage": {"value": 0.7, "ci95": [0.5, 0.8]}}
ERROR = {key: NONE[key] for key in ("kind", "causes", "truth", "components", "distance", "world", "clear")}
ERROR |= {"set": "c", "verdict": "error", "error": "no trials"}


def test_the_one_number_counts_every_data_set_and_an_unusable_one_as_wrong() -> None:
    rows = [NONE, ALARM, ERROR]
    score = summarise(rows)
    assert (score["first"]["right"], score["first"]["n"]) == (1, 3)
    assert score["none"]["false_alarms"]["right"] == 2
    assert "first answers that are right: 1/3" in lines(rows, score)
    assert "1 of 3 first answers are right" in str(score_page("rig", rows, score))


def lifelike(name, truth, first, right, **changed):
    causes = ["loose_pad"] if truth == ["unknown"] else truth
    judged = {"first_right": right, "first_in_class": right, "covered": right}
    return LIFELIKE | {"set": name, "causes": causes, "truth": truth, "first": first} | judged | changed


def test_lifelike_rigs_are_counted_apart_and_wrong_ones_that_are_sure_are_few() -> None:
    """The interval holds in three of four; the class that the diagnosis states is no sure miss."""
    rows = [
        lifelike("a", ["sensor_lag"], ["sensor_lag"], True),
        lifelike("b", ["sensor_lag"], ["end_stop"], False, ratio=0.9),
        lifelike("c", ["unknown"], ["unknown"], True, verdict="unknown", shrinkage=None),
        lifelike("d", ["unknown"], ["gravity"], False, verdict="ambiguous"),
        lifelike("e", [], ["gravity"], True),
        lifelike("f", ["gravity"], ["end_stop"], False, first_in_class=True, shrinkage=None),
        ERROR | {"set": "g", "kind": "lifelike", "background": ["gravity"]},
    ]
    score = summarise([NONE, *rows])
    counts = {name: (s["right"], s["n"]) for name, s in score["lifelike"].items() if "n" in s}
    assert counts == {
        "right": (3, 7), "right_in_class": (4, 7), "named": (2, 5), "unknown": (1, 2), "identified_wrong": (1, 7),
    }  # fmt: skip
    inside = score["lifelike"]["shrinkage"]["inside"]
    assert (inside["right"], inside["n"]) == (3, 4) == (score["shrinkage"]["inside"]["right"], 4)
    assert score["unknown"]["recalled"]["n"] == 0 and "unknown" not in score["confusion"]
    reached = {
        t.name: (t.asked, t.reached.split(";")[0], t.met) for t in targets(score) if "lifelike" in t.name
    }
    assert reached == {
        "lifelike rigs right": ("at least 75%", "42.9% (3/7", False),
        "lifelike rigs identified and wrong": ("at most 3%", "14.3% (1/7", False),
        "lifelike rigs with a foreign cause unknown": ("at least 85%", "50.0% (1/2", False),
    }
    text, page = lines(rows, score), str(score_page("rig", rows, score))
    assert (
        "b MISS  identified        sensor_lag among 2 small d 90.0: end_stop 0.90, real shrinkage 0.10"
        in text
    )
    assert "lifelike rigs without a foreign cause 2/5" in text
    assert "Large effects among small ones" in page and "loose_pad among 2 small" in page


def test_a_few_cases_do_not_show_that_a_target_is_met_but_may_miss_it() -> None:
    def alarms(rows):
        return next(t for t in targets(summarise(rows)) if "false alarms" in t.name).met

    assert [alarms([NONE] * n) for n in (1, 4, 5)] == [None, None, True]
    assert alarms([NONE, ALARM]) is False
    assert "0 of 0 targets are met" in str(score_page("rig", [NONE], summarise([NONE])))


def test_a_run_without_lifelike_rigs_says_nothing_of_them() -> None:
    score = summarise([NONE, ALARM])
    assert [t.met for t in targets(score) if "lifelike" in t.name] == [None] * 3
    assert "lifelike rigs without" not in lines([NONE], score)
    assert "Large effects among" not in str(score_page("rig", [NONE], score))


def test_what_no_law_explains_is_compared_with_what_the_laws_leave() -> None:
    """A tenth is scatter; a ratio of 0.5 leaves a quarter of the other nine tenths."""
    rows = [
        LIFELIKE | {"set": name, "ratio": ratio, "unexplained": {"ci95": [0.2, 0.3], "scatter": 0.1}}
        for name, ratio in (("a", 0.5), ("b", 0.7))
    ]
    score = summarise([NONE, LIFELIKE, *rows])
    inside = score["contributions"]["inside"]
    assert (inside["right"], inside["n"]) == (1, 2)
    assert score["contributions"]["median_width"] == pytest.approx(0.1)
    (target,) = (t for t in targets(score) if "no law" in t.name)
    assert target.met is False


def test_predicted_peaks_are_counted_over_all_data_sets() -> None:
    rows = [NONE | {"set": "a", "peaks_inside_corrected": [4, 4]}, ALARM | {"peaks_inside_corrected": [2, 4]}]
    inside = summarise([*rows, LIFELIKE])["predicted_peaks"]
    assert (inside["right"], inside["n"]) == (6, 8)
    (target,) = (t for t in targets(summarise(rows)) if "predicted peaks" in t.name)
    assert target.met is False
    assert summarise([NONE])["predicted_peaks"]["n"] == 0

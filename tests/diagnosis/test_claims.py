"""What is claimed of a corrected model, by the figures that are printed of held-out conditions."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from acf_jax.contact.read import of_diagnosis
from acf_jax.dataset import GapDataset, assess_dataset
from acf_jax.dataset.units import CONTACT_STIFFNESS, MASS
from acf_jax.diagnosis import Diagnosis, claims, diagnose
from acf_jax.diagnosis.claims import Change, Comparison, agreeing, compare, highest_probability
from acf_jax.diagnosis.document import document
from acf_jax.diagnosis.heldout import FORM_UNKNOWN, GapFigures, HeldOut, figures, form_error
from acf_jax.diagnosis.results import gap_model
from acf_jax.diagnosis.shrinkage import Shrinkage
from acf_jax.errors import InputError
from acf_jax.evidence.posterior import UNKNOWN
from acf_jax.gap_model import FORM_MOST, LONGEST_STEP_S, GapModel, read_model, write_model
from acf_jax.inference.forward import step_for
from acf_jax.inference.observations import observe
from acf_jax.predict import predict
from acf_jax.report import sentence
from tests.corrected import gap_model as made_up_model
from tests.diagnosis.conftest import CURVES, KEPT
from tests.few import few_explanations


def of(force: float | None, peak: float | None) -> GapFigures:
    return GapFigures(force, peak, peak)


@pytest.mark.parametrize(("before", "after", "better"), [
    (of(7.13, 55.0), of(9.81, 20.0), False),  # the force error grows
    (of(9.41, 1.6), of(1.32, 1.0), True),
    (of(9.41, 1.0), of(1.32, 1.1), False),  # a corrected peak would be farther off
    (of(1.241, 0.629), of(0.959, 0.633), True),  # printed as 0.63 % both
    (of(1.231, 0.6), of(1.229, 0.6), False),  # printed as 1.23 N both
    (of(None, 2.0), of(None, 1.0), True),  # peaks only
    (of(None, 2.0), of(None, 2.0), False),
    (of(5.0, None), of(4.0, None), True),  # all peaks are cut off
    (of(None, None), of(None, None), False),  # a single condition
])  # fmt: skip
def test_better_is_what_the_printed_figures_say(before: GapFigures, after: GapFigures, better: bool) -> None:
    found = compare(before, after, after)
    assert found.is_better is better
    assert found.tells_peak is (better and before.peak_rms_percent is not None)


def test_a_model_that_misses_its_own_trials_is_not_better() -> None:
    found = compare(of(5.0, 10.0), of(4.0, 9.0), of(3.0, 30.0))
    assert not found.is_better and "misses the peaks of the trials it was fitted to" in found.statement
    assert "force error 5 → 4 N, peak error 10 → 9 %" in found.statement


@pytest.mark.parametrize(("stated", "after", "expected"), [
    (Shrinkage(0.97, (0.91, 0.99)), 1.05, Shrinkage(0.97, (0.91, 0.99))),  # 1 - sqrt(0.1025/99) = 0.968
    (Shrinkage(0.86, (-1.9, 0.99)), 9.0, Shrinkage(0.1010, (-1.9, 0.99))),  # what else is known says nothing
    (Shrinkage(0.95, (0.90, 0.99)), 5.0, Shrinkage(0.95, (0.5076, 0.99))),  # the figures lie outside
])  # fmt: skip
def test_a_stated_shrinkage_holds_what_the_figures_give(
    stated: Shrinkage, after: float, expected: Shrinkage
) -> None:
    found = agreeing(stated, of(10.0, 1.0), of(after, 1.0), 1.0)
    assert found is not None and found.value == pytest.approx(expected.value, abs=1e-3)
    assert found.ci95 == pytest.approx(expected.ci95, abs=1e-3)


WORSE = Comparison(Change(7.13, 9.81), Change(55.0, 20.0))


def test_laws_beside_which_a_cause_is_missing_are_as_probable_as_what_they_explain() -> None:
    """Of 100 N^2 beside a floor of 20; even odds where held-out conditions say nothing of it."""
    better = Comparison(Change(10.0, 6.0), None)  # leaves 16 of 80
    assert highest_probability(better, 20**0.5, False) == 1.0
    assert highest_probability(better, 20**0.5, True) == pytest.approx(0.8)
    assert (
        highest_probability(better, None, True)
        == highest_probability(Comparison(None, None), 1.0, True)
        == 0.5
    )
    assert highest_probability(better, 10.0, True) == 0.5
    little, worse = Comparison(Change(10.0, 9.0), None), Comparison(Change(10.0, 11.0), None)
    assert highest_probability(little, 0.0, True) == pytest.approx(0.19)
    assert highest_probability(worse, 0.0, True) == 0.0
    assert highest_probability(worse, 0.0, False) == 0.5


@pytest.mark.parametrize(("force", "peak", "denied"), [
    (Change(7.13, 9.81), Change(55.0, 20.0), True),
    (Change(9.41, 9.41), None, True),
    (Change(9.41, 1.32), Change(1.0, 1.1), False),  # no better, but the force is
    (None, Change(2.0, 2.5), True),  # peaks only
    (None, None, False),  # a single condition
])  # fmt: skip
def test_held_out_conditions_speak_against_laws_that_do_not_help_there(
    force: Change | None, peak: Change | None, denied: bool
) -> None:
    assert Comparison(force, peak).is_denied is denied


def test_laws_that_held_out_conditions_speak_against_get_even_odds(
    gravity_set: GapDataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(claims, "compare", lambda *figures: WORSE)
    with few_explanations(KEPT, CURVES):
        d = diagnose(gravity_set)
    first, second, *_ = d.scored
    assert (first.explanation, second.explanation) == (("gravity",), UNKNOWN)
    assert first.probability == 0.5 and d.verdict == "ambiguous"
    assert any(
        line.startswith("what the fit did not see speaks against constant force") for line in d.warnings
    )


def no_better(diagnosed: Diagnosis) -> Diagnosis:
    """The diagnosis as it would be, had held-out conditions spoken against its correction."""
    return replace(diagnosed, comparison=WORSE, shrinkage_force=None, shrinkage_peak=None)


def test_every_answer_says_that_the_correction_is_no_better(diagnosed: Diagnosis, tmp_path: Path) -> None:
    d = no_better(diagnosed)
    assert "removes" not in sentence(d)
    assert (
        "is not better than the recalibrated one (force error 7.13 → 9.81 N, peak error 55 → 20 %)"
        in sentence(d)
    )
    content = document(d)
    assert content["corrected_is_better"] is False and document(diagnosed)["corrected_is_better"] is True
    assert content["shrinkage"] == {"force": None, "peak": None}
    model = gap_model(d)
    assert model.better is False and model.preferred == "recalibrated"
    path = tmp_path / "model.json"
    path.write_text(write_model(model))
    assert read_model(path) == model
    assert gap_model(diagnosed).preferred == "corrected"
    plain = replace(diagnosed, comparison=None)
    assert document(plain)["corrected_is_better"] is None and gap_model(plain).better is None


@pytest.mark.parametrize("value", [1e308, -1e308, 1.0])
def test_a_covariance_that_is_none_is_refused(value: float, tmp_path: Path) -> None:
    """Also one so large that a correlation overflows."""
    content = json.loads(write_model(made_up_model()))
    covariance = content["corrected"]["covariance"]
    covariance[0][1] = covariance[1][0] = value
    path = tmp_path / "model.json"
    path.write_text(json.dumps(content))
    with pytest.raises(InputError, match=r"corrected\.covariance: is none"):
        read_model(path)


def test_the_recalibrated_model_answers_where_the_corrected_one_is_no_better() -> None:
    model = made_up_model(form_error=0.02).model_copy(
        update={"better": False, "recalibrated_form_error": 0.05}
    )
    at = np.array([0.2]), np.array([70.0])
    (of_trials,), (corrected,), (recalibrated,) = (
        predict(model, *at, which) for which in (None, "corrected", "recalibrated")
    )
    assert of_trials.peak_force == recalibrated.peak_force != corrected.peak_force
    assert (
        of_trials.contact_peak_force_std
        > 0.05 * of_trials.contact_peak_force
        > corrected.contact_peak_force_std
    )
    contact = of_diagnosis(model)
    assert contact.names == (*contact.names[:4], "v_e", "f_p")  # the paper's model
    assert contact.form_error == 0.05 and contact.better is False
    assert [len(v.theta) for v in contact.others] == [5]
    assert contact.main.weight == sum(v.weight for v in contact.others)
    assert "not better than the recalibrated one" in contact.doubt
    assert of_diagnosis(model, which="corrected").form_error == 0.02
    assert of_diagnosis(model.model_copy(update={"better": True})).doubt == ""
    earlier = GapModel.model_validate(model.model_dump(by_alias=True, exclude={"better"}))
    assert earlier.better is None and of_diagnosis(earlier).doubt == ""


def held(peak: list[float], measured: list[float]) -> HeldOut:
    nothing = np.zeros((len(peak), 1))
    return HeldOut(nothing, nothing, np.array(peak), np.array(measured))


def test_what_is_written_is_bounded_where_it_arises() -> None:
    """A model that misses peaks by sixteen times their size could not be written, after minutes."""
    assert form_error(held([1700.0] * 4, [100.0] * 4), 1.0) == FORM_MOST
    assert form_error(held([100.0] * 4, [np.nan] * 4), 1.0) == FORM_UNKNOWN
    assert form_error(held([110.0, 110.0, 5.0], [100.0, 100.0, np.nan]), 0.0) == pytest.approx(
        0.1 / 0.455**0.5
    )
    assert form_error(held([100.0] * 4, [100.0] * 4), 5.0) == 0.0


def test_cut_off_peaks_do_not_count(diagnosed: Diagnosis) -> None:
    held_out = diagnosed.held["corrected"]
    measured = held_out.measured_peak.copy()
    measured[::2] = np.nan
    partly = figures(diagnosed.observations, replace(held_out, measured_peak=measured))
    error = 100 * (held_out.peak / held_out.measured_peak - 1)[1::2]
    assert partly.peak_rms_percent == pytest.approx(np.sqrt((error**2).mean()))
    nowhere = replace(held_out, measured_peak=np.full_like(measured, np.nan))
    assert figures(diagnosed.observations, nowhere).peak_rms_percent is None
    json.dumps(document(diagnosed), allow_nan=False)


@pytest.mark.parametrize(("change", "what"), [
    ({"contact_velocity": -0.1}, "needs a velocity above 0"),
    ({"pretension": -60.0}, "pretension of 0 N or more"),
])  # fmt: skip
def test_data_sets_from_arrays_are_checked_before_the_fits(
    gravity_set: GapDataset, change: dict[str, float], what: str
) -> None:
    trials = (replace(gravity_set.trials[0], **change), *gravity_set.trials[1:])
    with pytest.raises(InputError, match=what):
        observe(assess_dataset(replace(gravity_set, trials=trials)))


def test_time_in_nanoseconds_is_refused_before_the_fits(gravity_set: GapDataset) -> None:
    trials = tuple(
        replace(t, trace=replace(t.trace, time=1e-6 * t.trace.time), peak_force=None)
        for t in gravity_set.trials
        if t.trace
    )
    with pytest.raises(InputError, match="give time_s in seconds"):
        observe(assess_dataset(replace(gravity_set, trials=trials)))


def test_the_slowest_rig_that_a_data_set_may_state_can_be_written() -> None:
    """Of 100 kg on 2 N/mm a step of the simulation takes 22 ms."""
    slow = step_for(MASS.high, 0.0, 0.0, CONTACT_STIFFNESS.low)
    assert 0.02 < slow < LONGEST_STEP_S
    model = made_up_model().model_copy(update={"step_s": slow})
    assert GapModel.model_validate(json.loads(write_model(model))) == model

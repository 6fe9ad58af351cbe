"""A diagnosis from end to end, on data from a world that shares no code with the fitted simulator."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from acf_jax.dataset import GapDataset, Measurement, Prior, RigPrior, Trace, Trial, assess_dataset
from acf_jax.diagnosis import Diagnosis, diagnose
from acf_jax.diagnosis.candidates import fit_nominal, fit_single
from acf_jax.diagnosis.document import document
from acf_jax.diagnosis.heldout import figures, hold_out
from acf_jax.diagnosis.results import _corners, gap_model
from acf_jax.diagnosis.shrinkage import Shrinkage
from acf_jax.diagnosis.trial_peaks import measured_peaks
from acf_jax.diagnosis.where import gap_map
from acf_jax.errors import InputError
from acf_jax.evidence.posterior import UNKNOWN
from acf_jax.gap_model import read_model, write_model
from acf_jax.inference.baseline import Ground
from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.forward import Grid, forward
from acf_jax.inference.observations import observe
from acf_jax.inference.parameters import Explanation, begin, parameters, starts
from acf_jax.inference.projection import Projector
from acf_jax.predict import predict
from acf_jax.report import write_report
from tests.diagnosis.conftest import CURVES, KEPT
from tests.few import few_explanations


def test_names_the_cause_and_shrinks_the_gap(diagnosed: Diagnosis) -> None:
    content = document(diagnosed)
    assert content["schema"] == "acf-gap-diagnosis/1"
    assert content["verdict"] in ("identified", "ambiguous")  # what is unknown may stand beside it
    assert content["explanations"][0]["effects"] == ["gravity"]
    assert content["explanations"][0]["probability"] > 0.6
    assert sum(e["probability"] for e in content["explanations"]) == pytest.approx(1.0)
    assert max(content["where"]["component"], key=content["where"]["component"].get) == "actuator"
    assert sum(content["where"]["phase"].values()) == pytest.approx(1.0, abs=1e-3)
    floor = content["gap"]["noise_floor_rms_n"]
    left, gap = (content["gap"][m]["force_rms_n"] ** 2 - floor**2 for m in ("corrected", "recalibrated"))
    assert left < 0.1 * gap  # in variance, beyond what no model could predict
    low, high = content["shrinkage"]["force"]["ci95"]
    assert low <= content["shrinkage"]["force"]["value"] <= high <= 1
    json.dumps(content, allow_nan=False)
    page = (Path(__file__).parents[2] / "docs/diagnosis_json.md").read_text("utf-8")
    for key, value in content.items():
        assert f"`{key}" in page  # alone, or followed by a dot and one of its own keys
        inner = value if isinstance(value, dict) and key not in ("parameters", "absorbed") else {}
        assert all(f"`{name}`" in page or f"`{key}.{name}`" in page for name in inner), key


def test_a_cause_that_the_library_lacks_is_unknown_at_its_component(gravity_set: GapDataset) -> None:
    with few_explanations(KEPT, CURVES):
        found = diagnose(gravity_set, without="gravity")  # one name, or many
    assert found.scored[0].explanation == UNKNOWN
    assert found.corrected.explanation == ("unknown_actuator",)
    assert max(found.component, key=lambda name: found.component[name]) == "actuator"
    assert [f.explanation for f in found.fits][:2] == [(), ("unknown_actuator",)]  # most probable first


def test_nothing_acts_at_a_component_that_the_rig_does_not_have(gravity_set: GapDataset) -> None:
    """Neither its laws nor its free curve: what acts there in truth is named elsewhere, or is unknown elsewhere."""
    with few_explanations(("gravity", "sensor_scale"), ("unknown_actuator", "unknown_sensor")):
        found = diagnose(gravity_set, without=["actuator"])
    assert {name for f in found.fits for name in f.explanation} == {"sensor_scale", "unknown_sensor"}
    assert found.component["actuator"] == 0.0 and [x.effect for x in found.detectability] == ["sensor_scale"]
    content = document(found)["contributions"]
    background = next(part for part in content if part["effect"] == "background")
    assert background["component"]["actuator"] == 0.0


@pytest.mark.parametrize("without", [["gravty"], "gravty"], ids=["one of many", "a string"])
def test_what_cannot_be_the_cause_has_to_be_an_effect(
    gravity_set: GapDataset, without: list[str] | str
) -> None:
    with pytest.raises(ValueError, match="no effect is called 'gravty'; did you mean 'gravity'"):
        diagnose(gravity_set, without=without)


def test_something_has_to_be_left(gravity_set: GapDataset) -> None:
    with pytest.raises(ValueError, match="leave at least one"):
        diagnose(gravity_set, without=["actuator", "contact", "robot", "sensor"])


def test_the_model_file_comes_back_as_it_was(diagnosed: Diagnosis, tmp_path: Path) -> None:
    model = gap_model(diagnosed)
    path = tmp_path / "model.json"
    path.write_text(write_model(model))
    assert read_model(path) == model
    assert model.verdict == diagnosed.verdict
    content = json.loads(path.read_text())
    assert content["rel_std"] == list(diagnosed.observations.rel_std)
    del content["verdict"], content["corners"], content["rel_std"]  # as earlier versions wrote it
    path.write_text(json.dumps(content))
    assert read_model(path) == model.model_copy(update={"verdict": None, "corners": (), "rel_std": None})


def test_the_model_file_holds_what_was_known_and_steps_as_fine_as_any_explanation(
    diagnosed: Diagnosis,
) -> None:
    model = gap_model(diagnosed)
    known = np.diag(np.square(diagnosed.dataset.rig.stds))
    assert np.array(model.nominal.covariance) == pytest.approx(known)
    leader, other = diagnosed.corrected, next(f for f in diagnosed.fits if f.explanation == ("sensor_scale",))
    fine = replace(other, grid=other.grid._replace(h=leader.grid.h / 4))
    fits = tuple(fine if f is other else f for f in diagnosed.fits)
    probability = tuple(0.5 if f in (leader, fine) else 0.0 for f in fits)
    both = replace(
        diagnosed, fits=fits, probability=probability, credible=(leader.explanation, fine.explanation)
    )
    assert gap_model(both).step_s == fine.grid.h


def test_an_untared_sensor_leaves_the_errors_of_peaks(gravity_set: GapDataset, diagnosed: Diagnosis) -> None:
    offset = 7.0
    trials = [
        replace(t, trace=replace(t.trace, force=t.trace.force + offset))
        for t in gravity_set.trials
        if t.trace
    ]
    untared = replace(gravity_set, trials=tuple(trials))
    quality = assess_dataset(untared)
    peaks = measured_peaks(quality, observe(quality))
    assert peaks == pytest.approx(diagnosed.held["nominal"].measured_peak, abs=0.2)


def test_of_a_single_condition_no_figure_is_called_held_out(gravity_set: GapDataset, tmp_path: Path) -> None:
    first = gravity_set.trials[0]
    forces = [first.trace.force + 0.1 * k for k in range(3)]  # type: ignore[union-attr]
    trials = [
        replace(first, name=f"t{k}", trace=replace(first.trace, force=force))  # type: ignore[type-var]
        for k, force in enumerate(forces)
    ]
    with few_explanations(KEPT, CURVES):
        found = diagnose(replace(gravity_set, trials=tuple(trials)))
    content = document(found)
    assert all(content["gap"][name]["force_rms_n"] is None for name in ("recalibrated", "corrected"))
    assert content["gap"]["nominal"]["force_rms_n"] > 0
    assert content["shrinkage"] == {"force": None, "peak": None}
    assert any("one condition" in warning for warning in content["warnings"])
    write_report(tmp_path / "report.html", found, content)
    assert "so none is held out" in (tmp_path / "report.html").read_text()


def test_a_free_curve_that_goes_astray_where_it_did_not_see_predicts_no_force(
    gravity_set: GapDataset, diagnosed: Diagnosis
) -> None:
    """It left figures that are no numbers, which model.json cannot hold."""
    observations = diagnosed.observations
    known = [name for name, _ in parameters(("unknown_actuator",))]
    theta = begin(observations.prior.values, starts("unknown_actuator")[1])
    theta[known.index("unknown_actuator.stroke_3_n")] = 2e3
    fitted = fit(observations, ("unknown_actuator",), theta, warm=True, iterations=0)
    assert not np.isfinite(fitted.objective)
    measured = diagnosed.held["nominal"].measured_peak
    held = hold_out(observations, fitted, measured, diagnosed.nominal, refit=False)
    assert np.isfinite(held.excess).all() and np.isfinite(held.peak).all()
    assert figures(observations, held).peak_max_percent == pytest.approx(100.0)


def test_where_there_are_peaks_only_no_force_is_stated(diagnosed: Diagnosis) -> None:
    o = diagnosed.observations
    here = o.condition[0]
    beside_traces = replace(o, peak_only=o.condition == here)
    gaps = gap_map(beside_traces, diagnosed.fits[0], diagnosed.held["recalibrated"]).conditions
    assert [gap.excess_rms_n is None for gap in gaps] == [c == here for c in np.unique(o.condition)]
    assert sum(gap.share for gap in gaps) == pytest.approx(1.0)


def test_a_trace_that_ends_at_contact_is_left_out(gravity_set: GapDataset) -> None:
    """With the rest it ended in a traceback."""
    first, *others = gravity_set.trials[:5]
    assert first.trace is not None
    before = first.trace.time <= 0.0
    force = first.trace.force[before]
    force[-1] = first.pretension
    trace = replace(first.trace, time=first.trace.time[before], force=force)
    short = replace(first, trace=trace, peak_force=None)
    with few_explanations(("gravity",), ("unknown_sensor",)):
        found = diagnose(replace(gravity_set, trials=(short, *others)))
    assert set(found.excluded) == {first.name}
    assert len(found.observations.names) == 4
    with pytest.raises(InputError, match="go on behind it"):
        diagnose(replace(gravity_set, trials=(short, *others[:2])))


def test_noise_below_what_the_simulation_resolves_counts_as_that(gravity_set: GapDataset) -> None:
    """With 1e-6 N, as a simulated set may state it, no fit counted as stable; covariances were not symmetric."""
    quality = assess_dataset(gravity_set)
    exact = replace(quality, noise=replace(quality.noise, std=1e-6))
    observations = observe(exact)
    assert 1e-4 < observations.noise.std < 1e-2
    fitted = fit_nominal(observations)
    assert np.isfinite(fitted.objective)
    deviation = np.sqrt(np.diag(fitted.covariance))
    correlation = fitted.covariance / deviation / deviation[:, None]
    assert correlation == pytest.approx(correlation.T, abs=1e-9)
    assert np.linalg.eigvalsh(correlation).min() > -1e-9


def test_a_trace_is_compared_to_its_end_where_the_robot_presses_on() -> None:
    """A sensor that clips behind the fourth period had been no gap."""
    rig = RigPrior(Prior(2.0, 0.04), Prior(420.0, 60.0), Prior(3e4, 1.5e3), Prior(5e5, 4e4))
    v_e, f_p = np.array([0.1, 0.2, 0.3, 0.3]), np.array([60.0, 60.0, 60.0, 90.0])
    impacts = forward((), rig.values, v_e, f_p, Grid(1e-4, 600)).sensed
    noise = np.random.default_rng(0).normal(0.0, 0.5, (4, 641))

    def left(limit: float) -> float:
        """Chi-square of a sample that the recalibrated model leaves."""
        read = np.minimum(np.pad(impacts, ((0, 0), (40, 0))), limit) + noise
        trials = tuple(
            Trial(f"t{i}", v_e[i], f_p[i], None, Trace(1e-4 * np.arange(-40, 601), read[i])) for i in range(4)
        )
        dataset = GapDataset(Path("clipped"), "", rig, Measurement(0.5, 0.005, 0.005), trials)
        observations = observe(assess_dataset(dataset))
        return 2 * fit_nominal(observations).objective / observations.n_used

    assert left(np.inf) < 1.1
    assert left(impacts[:, :480].max()) > 2.0


@pytest.mark.parametrize(
    ("conditions", "corners"),
    [
        (
            [(v, f) for v in (0.1, 0.2, 0.3) for f in (50, 70, 90)],
            [(0.1, 50), (0.1, 90), (0.3, 50), (0.3, 90)],
        ),
        ([(0.1, 50), (0.2, 55), (0.3, 50), (0.1, 90), (0.1, 70)], [(0.1, 50), (0.1, 90), (0.3, 50)]),
        ([(0.1, 50), (0.3, 70), (0.2, 60)], [(0.1, 50), (0.3, 70)]),
        ([(0.1, 0)], [(0.1, 0), (0.1, 0)]),
    ],
)
def test_the_corners_enclose_the_conditions(conditions, corners) -> None:  # type: ignore[no-untyped-def]
    assert list(_corners(*np.array(conditions, float).T)) == corners


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda m: m.update(surplus=1), "surplus"),
        (lambda m: m["corrected"].update(effects=["magic"]), "magic"),
        (lambda m: m["corrected"]["theta"].pop(), "values"),
        (lambda m: m["nominal"]["theta"].__setitem__(0, float("nan")), "NaN, which is no number"),
        (lambda m: m.update(step_s=0), "step_s"),
        (lambda m: m["corners"][0].__setitem__(0, 0.001), "corners"),
    ],
)
def test_a_damaged_model_file_is_named(diagnosed: Diagnosis, tmp_path: Path, change, word: str) -> None:  # type: ignore[no-untyped-def]
    content = json.loads(write_model(gap_model(diagnosed)))
    change(content)
    path = tmp_path / "model.json"
    path.write_text(json.dumps(content))
    with pytest.raises(InputError, match=word):
        read_model(path)


def test_corners_may_miss_the_tried_range_by_rounding(diagnosed: Diagnosis, tmp_path: Path) -> None:
    """Pretensions of 110 N and of 1.1 * 100 N have no area: the ends of a line are left, of which none is largest."""
    v_e, f_p = np.array([0.1, 0.2, 0.3]), np.array([110.0, 1.1 * 100, 110.0])
    corners = _corners(v_e, f_p)
    assert max(f for _, f in corners) < f_p.max()
    tried = {"corners": corners, "v_range": (0.1, 0.3), "f_p_range": (110.0, float(f_p.max()))}
    path = tmp_path / "model.json"
    path.write_text(write_model(gap_model(diagnosed).model_copy(update=tried)))
    assert read_model(path).corners == corners


def test_a_model_says_whether_the_correction_was_seen_to_help(diagnosed: Diagnosis) -> None:
    low, high = diagnosed.shrinkage_force.ci95  # type: ignore[union-attr]
    assert low > 0 and gap_model(diagnosed).shown_closer is True
    unsure = Shrinkage(0.4, (-0.1, high))
    for shrinkage in (unsure, None):
        assert gap_model(replace(diagnosed, shrinkage_force=shrinkage)).shown_closer is False
    assert gap_model(replace(diagnosed, corrected=diagnosed.fits[0])).shown_closer is None


def test_predictions_end_with_contact_and_carry_uncertainty(diagnosed: Diagnosis) -> None:
    model = gap_model(diagnosed)
    one, two = predict(model, np.array([0.1, 0.2]), np.array([80.0, 80.0]), sample_rate=20e3)
    assert two.peak_force > one.peak_force
    assert one.peak_force == one.force.max()
    assert one.time[np.argmax(one.force)] == one.peak_time
    assert one.peak_force_std > 0
    assert (one.contact_force >= 0).all() and one.time[-1] <= 0.060
    measured = {t.condition: t for t in diagnosed.dataset.trials if t.name not in diagnosed.excluded}
    condition, trial = next(iter(measured.items()))
    (again,) = predict(model, np.array([condition[0]]), np.array([condition[1]]))
    assert trial.trace is not None
    assert again.peak_force == pytest.approx(trial.trace.force.max(), rel=0.05)


def test_derivatives_of_the_objective_are_right(gravity_set: GapDataset) -> None:
    """The Gauss-Newton gradient vanishes at the optimum: a step to either side costs."""
    observations = observe(assess_dataset(gravity_set))
    best = fit_single(Ground.of(observations, fit_nominal(observations)), "gravity")
    for k in range(len(best.u)):
        for step in (-0.3, 0.3):
            u = best.u.copy()
            u[k] += step / np.sqrt(best.hessian[k, k])
            moved = fit(
                observations, ("gravity",), best.coordinates.value(u), best.nuisance, warm=True, iterations=0
            )
            assert moved.objective > best.objective - 1e-6


@pytest.mark.parametrize("explanation", [(), ("gravity",)])
def test_longer_steps_leave_the_chi_square(
    gravity_set: GapDataset, explanation: Explanation, monkeypatch: pytest.MonkeyPatch
) -> None:
    observations = observe(assess_dataset(gravity_set))
    start = begin(observations.prior.values, [-5.0] * len(explanation))
    near = fit(observations, explanation, start)
    found = fit(observations, explanation, near.theta, near.nuisance, warm=True)
    monkeypatch.setattr("acf_jax.inference.fit.STRIDE", 0.25)
    finer = fit(observations, explanation, found.theta, found.nuisance, warm=True)
    assert finer.grid.h < found.grid.h / 4
    assert 2 * finer.objective == pytest.approx(2 * found.objective, abs=0.2)


def test_projection_removes_what_the_parameters_imitate(gravity_set: GapDataset) -> None:
    observations = observe(assess_dataset(gravity_set))
    nominal: Fit = fit_nominal(observations)
    projector = Projector.of(nominal)
    imitated = nominal.linearised().by_parameter[:, 0]
    (left,) = projector.gram(imitated[None])[0]
    assert left < 1.0 + 1e-9 < (imitated**2).sum()  # what is left is at most the prior's own weight


def test_the_same_data_give_the_same_fit_whatever_the_order_of_trials(gravity_set: GapDataset) -> None:
    observations = observe(assess_dataset(gravity_set))
    reversed_set = replace(gravity_set, trials=gravity_set.trials[::-1])
    turned = observe(assess_dataset(reversed_set))
    one, two = fit_nominal(observations), fit_nominal(turned)
    np.testing.assert_allclose(one.theta, two.theta, rtol=1e-3, atol=1e-6)

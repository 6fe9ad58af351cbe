"""A sensor on the robot's side of a tool: what it reads is no gap where the tool's mass is stated."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from acf_jax.dataset import GapDataset, Trace, assess_dataset
from acf_jax.diagnosis import diagnose
from acf_jax.diagnosis.results import gap_model
from acf_jax.gap_model import check_model, write_model
from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.forward import Grid, forward
from acf_jax.inference.observations import observe
from acf_jax.inference.parameters import begin
from acf_jax.predict import predict
from tests.dataset.impacts import K_C, K_F, D, M, contact_force, made_up
from tests.few import few_explanations

RIG, TOOL = np.array([M, D, K_F, K_C]), 1.3


def behind_a_tool(dataset: GapDataset, stated: float | None) -> GapDataset:
    """The readings of a sensor between robot and tool; what they lack is found by a solver of its own."""
    trials = []
    for trial in dataset.trials:
        assert trial.trace is not None
        time = trial.trace.time
        # x'' = F_C''/k_C but for its sign, since F_C = k_C (v t - x) + F_P; nothing pulls once contact is lost
        lacking = -TOOL * second_derivative(time, trial.contact_velocity, trial.pretension) / K_C
        trials.append(replace(trial, trace=Trace(time, trial.trace.force - lacking), peak_force=None))
    measurement = replace(dataset.measurement, tool_mass_kg=stated)
    return replace(dataset, trials=tuple(trials), measurement=measurement)


def second_derivative(time: np.ndarray, v: float, f_p: float, eps: float = 2e-6) -> np.ndarray:
    """Of the contact force at these times, zero before contact and once it is lost, N/s^2."""
    at = np.maximum(time, 2 * eps)
    left, mid, right = (contact_force(at + shift, v, f_p) for shift in (-eps, 0.0, eps))
    return np.where((time >= 0) & (right > 0), (left - 2 * mid + right) / eps**2, 0.0)


def recalibrated(dataset: GapDataset) -> tuple[Fit, float]:
    """The paper's model, which is true here, and its chi-square of a sample."""
    o = observe(assess_dataset(dataset))
    fitted = fit(o, (), begin(o.prior.values))
    return fitted, 2 * fitted.objective / o.n_used


def test_derivatives_of_what_is_read_equal_finite_differences() -> None:
    v, f, grid = np.array([0.2, 0.3]), np.array([60.0, 100.0]), Grid(1e-4, 80, pull=1.0, tool_mass=TOOL)
    found = forward((), RIG, v, f, grid)
    for k in range(4):
        up, down = (forward((), RIG * (1 + s * 1e-4 * np.eye(4)[k]), v, f, grid).sensed for s in (1, -1))
        slope = (up - down) / (2e-4 * RIG[k])
        assert found.tangents[:, k] == pytest.approx(slope, abs=1e-3 * np.abs(slope).max())
    assert np.array_equal(found.contact, forward((), RIG, v, f, grid._replace(tool_mass=None)).contact)


def test_a_tool_that_is_stated_is_no_gap_and_one_that_is_not_strains_the_rig() -> None:
    dataset = made_up(0, end=0.009)
    stated, left = recalibrated(behind_a_tool(dataset, TOOL))
    unstated, _ = recalibrated(behind_a_tool(dataset, None))
    std = np.sqrt(np.diag(stated.covariance))[:4]
    assert left < 1.6 and (np.abs(stated.theta[:4] - RIG) < 3 * std).all()
    prior = observe(assess_dataset(dataset)).prior
    assert np.abs((unstated.theta[:4] - prior.values) / prior.stds).max() > 5
    assert unstated.objective > 5 * stated.objective


def test_the_cause_is_found_behind_a_tool_and_the_contact_force_is_not_the_reading(tmp_path: Path) -> None:
    dataset = behind_a_tool(made_up(0, end=0.009), TOOL)
    trials = [replace(t, trace=Trace(t.trace.time, 1.2 * t.trace.force)) for t in dataset.trials if t.trace]
    with few_explanations(("gravity", "sensor_scale"), ("unknown_sensor",)):
        d = diagnose(replace(dataset, trials=tuple(trials)))
    assert d.scored[0].explanation == ("sensor_scale",)
    assert d.corrected.physical[4] == pytest.approx(0.2, abs=0.03)
    model = gap_model(d)
    assert model.tool_mass_kg == TOOL
    assert check_model(tmp_path, json.loads(write_model(model))) == model
    at = np.array([0.3]), np.array([80.0])
    (read,), (bare,) = (predict(m, *at) for m in (model, model.model_copy(update={"tool_mass_kg": None})))
    assert read.contact_peak_force == bare.contact_peak_force
    assert read.peak_force < 0.5 * bare.peak_force

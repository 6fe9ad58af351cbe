"""What a filter does to data it does to the model: forces, derivatives, fits, predictions."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfilt, sosfiltfilt

from acf_jax.dataset import GapDataset, LowPass, Trace, assess_dataset
from acf_jax.dataset.filtered import assess_low_passed
from acf_jax.dataset.low_pass import Filter
from acf_jax.diagnosis import diagnose
from acf_jax.diagnosis.results import gap_model
from acf_jax.evidence.posterior import UNKNOWN
from acf_jax.gap_model import check_model, write_model
from acf_jax.inference.fit import Fit, fit, grid_for
from acf_jax.inference.forward import Grid, forward
from acf_jax.inference.observations import observe
from acf_jax.inference.parameters import begin
from acf_jax.predict import predict
from tests.dataset.impacts import K_C, K_F, D, M, made_up
from tests.few import few_explanations

RIG = np.array([M, D, K_F, K_C])
RATE = 8000.0
CAUSAL, ZERO = LowPass(400.0, 4), LowPass(400.0, 2, True)
BOTH = pytest.mark.parametrize("way", [CAUSAL, ZERO], ids=["causal", "zero phase"])


@BOTH
def test_the_model_is_filtered_as_a_fine_recording_of_it_would_be(way: LowPass) -> None:
    """The force steps to F_P at time 0 itself, on whatever grid it is simulated."""
    v, f = np.array([0.2, 0.3]), np.array([60.0, 100.0])
    coarse = forward((), RIG, v, f, Grid(1e-4, 220, low_pass=way))
    fine = forward((), RIG, v, f, Grid(2.5e-5, 1000))
    before = np.zeros((2, 1200))
    recorded = np.concatenate([before, fine.sensed], axis=1)
    recorded[:, 1200] /= 2
    sections = butter(way.order, way.cutoff_hz, fs=1 / 2.5e-5, output="sos")
    right = (sosfiltfilt if way.zero_phase else sosfilt)(sections, recorded)[:, 1200::4][:, :150]
    assert np.abs(coarse.sensed[:, :150] - right).max() < 0.006 * fine.sensed.max()
    assert np.array_equal(coarse.contact, forward((), RIG, v, f, Grid(1e-4, 220)).contact)
    up, down = (
        forward((), RIG * (1 + s * 1e-4 * np.eye(4)[3]), v, f, Grid(1e-4, 220, low_pass=way)) for s in (1, -1)
    )
    slope = (up.sensed - down.sensed) / (2e-4 * K_C)
    assert coarse.tangents[:, 3] == pytest.approx(slope, abs=1e-3 * np.abs(slope).max())


def filtered(dataset: GapDataset, way: LowPass, is_stated: bool = True) -> GapDataset:
    """A recording that its user filtered."""
    trials = []
    for trial in dataset.trials:
        assert trial.trace is not None
        force = Filter(way, 1 / RATE)(trial.trace.force)
        trials.append(replace(trial, trace=Trace(trial.trace.time, force), peak_force=None))
    measurement = replace(
        dataset.measurement, low_pass=way if is_stated else None, force_noise_std_n=Filter(way, 1 / RATE).gain
    )
    return replace(dataset, trials=tuple(trials), measurement=measurement)


def recalibrated(dataset: GapDataset) -> tuple[Fit, float]:
    """The paper's model, which is true here, and its chi-square of a sample."""
    o = observe(assess_dataset(dataset))
    fitted = fit(o, (), begin(o.prior.values))
    return fitted, 2 * fitted.objective / o.n_used


@pytest.mark.parametrize(
    "way", [CAUSAL, pytest.param(ZERO, marks=pytest.mark.long)], ids=["causal", "zero phase"]
)
def test_a_filter_that_is_stated_is_no_gap(way: LowPass) -> None:
    dataset = made_up(0, end=0.03)
    whole, _ = recalibrated(dataset)
    stated, left = recalibrated(filtered(dataset, way))
    _, unstated = recalibrated(filtered(dataset, way, is_stated=False))
    assert left < 1.6 and unstated > 5 * left
    std = np.sqrt(np.diag(stated.covariance))[:4]
    assert (np.abs(stated.theta[:4] - whole.theta[:4]) < 2.5 * std).all()
    assert (np.abs(stated.theta[:4] - RIG) < 3 * std).all()


def test_near_the_end_of_a_recording_nothing_is_compared_that_would_know_what_follows() -> None:
    short = made_up(0, end=0.008)
    ends = {
        way.zero_phase: float(o.time[o.used].max())
        for way in (CAUSAL, ZERO)
        for o in [observe(assess_dataset(filtered(short, way)))]
    }
    assert ends[False] > 0.0067 and ends[True] < 0.008 - 0.0028


def test_compared_samples_lie_two_a_period_of_the_cutoff() -> None:
    o = observe(assess_low_passed(made_up(0), CAUSAL))
    assert o.spacings == pytest.approx(np.full(len(o.names), 10 / RATE))
    assert np.diff(o.time[0][o.used[0]]).min() == pytest.approx(10 / RATE)
    grid = grid_for(o, ("sensor_scale",))
    assert grid.low_pass == CAUSAL and grid.h <= 0.1 / 400.0


@pytest.mark.long
def test_a_ring_above_the_cutoff_is_out_of_the_way(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Each trial rings at 1.5 kHz with a phase of its own; the gain error shows through the filter all the same."""
    rng = np.random.default_rng(3)
    dataset = made_up(0, end=0.02)
    trials = []
    for trial in dataset.trials:
        assert trial.trace is not None
        time = trial.trace.time
        ring = 25 * np.exp(-np.maximum(time, 0) / 4e-3) * np.sin(2 * np.pi * 1500 * time + 6.3 * rng.random())
        force = 1.06 * trial.trace.force + np.where(time > 0, ring, 0.0)
        trials.append(replace(trial, trace=Trace(time, force), peak_force=None))
    with few_explanations(("gravity", "sensor_scale"), ("unknown_sensor",)):
        d = diagnose(replace(dataset, trials=tuple(trials)), low_pass=CAUSAL)
    laws = [s.explanation for s in d.scored if s.explanation != UNKNOWN]
    assert laws[0] == ("sensor_scale",) and d.component["sensor"] > 0.9
    gain = next(f for f in d.fits if f.explanation == ("sensor_scale",))
    assert gain.physical[4] == pytest.approx(0.06, abs=0.015)
    assert d.dataset.measurement.low_pass == d.observations.low_pass == CAUSAL
    assert any(line.startswith("data and model are low-passed at 400 Hz") for line in d.warnings)
    model = gap_model(d)
    assert check_model(tmp_path_factory.mktemp("m"), json.loads(write_model(model))) == model
    (read,), (raw,) = (
        predict(m, np.array([0.3]), np.array([80.0]))
        for m in (model, model.model_copy(update={"low_pass": None}))
    )
    assert read.contact_peak_force == raw.contact_peak_force
    assert read.contact_peak_force_std == pytest.approx(raw.contact_peak_force_std, rel=0.05)
    assert 2e-4 < read.peak_time - raw.peak_time < 2e-3 and read.peak_force < raw.peak_force

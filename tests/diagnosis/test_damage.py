"""How sure a verdict on damaged data may be, and that what is cut off is not fitted."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from acf_jax.dataset import GapDataset, Trial, assess_dataset
from acf_jax.diagnosis import Diagnosis, diagnose
from acf_jax.diagnosis.damage import highest_probability, tempered
from acf_jax.diagnosis.document import document
from acf_jax.evidence.posterior import UNKNOWN, Posterior, Scored
from acf_jax.inference.observations import observe
from acf_jax.report import doubts, sentence, write_report
from tests.diagnosis.conftest import CURVES, KEPT
from tests.few import few_explanations


@pytest.mark.parametrize(
    ("damaged", "highest"), [(0, 1.0), (1, 0.95), (5, 0.75), (10, 0.5)], ids=["none", "one", "half", "all"]
)
def test_a_verdict_is_no_surer_than_its_sound_trials_and_half_of_the_damaged(
    damaged: int, highest: float
) -> None:
    names = [f"t{i}" for i in range(10)]
    quality = SimpleNamespace(damaged=(*names[:damaged], "left out"))
    assert highest_probability(quality, names) == pytest.approx(highest)  # type: ignore[arg-type]


def test_on_damaged_data_nothing_is_more_than_99_percent_sure() -> None:
    names = [f"t{i}" for i in range(1000)]
    assert highest_probability(SimpleNamespace(damaged=("t3",)), names) == 0.99  # type: ignore[arg-type]


@pytest.mark.parametrize(("first", "other"), [(("gravity",), UNKNOWN), (UNKNOWN, ()), ((), UNKNOWN)])
def test_what_a_verdict_loses_goes_to_what_damage_may_hide(
    first: tuple[str, ...], other: tuple[str, ...]
) -> None:
    told = Posterior((Scored(first, 0.995), Scored(other, 0.004), Scored(("sensor_lag",), 0.001)), {}, {})
    found = tempered(told, 0.75)
    assert [(s.explanation, round(s.probability, 9)) for s in found.scored] == [
        (first, 0.75), (other, 0.249), (("sensor_lag",), 0.001)
    ]  # fmt: skip
    assert tempered(told, 1.0) == told
    even = tempered(Posterior((Scored(first, 0.995), Scored(other, 0.005)), {}, {}), 0.5)
    assert [s.explanation for s in even.scored] == [first, other]
    assert tempered(told, 0.2).scored[0].explanation == other
    rounded = tempered(Posterior((Scored(first, 0.9), Scored(other, 0.1 + 1e-15)), {}, {}), 0.5)
    assert [s.explanation for s in rounded.scored] == [first, other]  # above one in all by rounding


def cut_off(dataset: GapDataset, share: float) -> GapDataset:
    """The data set by a sensor whose range ends at a share of the largest force."""
    limit = round(share * max(float(t.trace.force.max()) for t in dataset.trials if t.trace), 1)

    def cut(trial: Trial) -> Trial:
        assert trial.trace is not None
        force = np.minimum(trial.trace.force, limit)
        return replace(trial, trace=replace(trial.trace, force=force), peak_force=float(force.max()))

    return replace(dataset, trials=tuple(map(cut, dataset.trials)))


@pytest.fixture(scope="module")
def half(gravity_set: GapDataset) -> Diagnosis:
    with few_explanations(KEPT, CURVES):
        return diagnose(cut_off(gravity_set, 0.55))


def test_a_force_that_is_cut_off_still_shows_its_cause_but_not_for_sure(half: Diagnosis) -> None:
    d = half
    share = len(d.quality.damaged) / len(d.observations.names)
    assert 0.2 < share < 0.8
    assert d.scored[0].explanation == ("gravity",)
    assert d.scored[0].probability <= 1 - share / 2 and sum(s.probability for s in d.scored) == pytest.approx(
        1
    )
    assert "> 99 %" not in sentence(d).split("Correcting")[0]
    lines = doubts(d)
    assert lines[0].startswith("the force is cut off at ") and lines[1].startswith("no probability above ")
    assert set(lines) <= set(d.warnings)


def test_what_is_cut_off_is_neither_fitted_nor_a_peak(half: Diagnosis) -> None:
    o, limit = half.observations, max(t.phase.cut_off or 0.0 for t in half.quality.trials if t.phase)
    cut = np.isin(o.names, half.quality.damaged)
    assert o.force[o.used].max() < limit - half.quality.noise.offset
    assert np.array_equal(np.isnan(half.held["corrected"].measured_peak), cut)
    assert (o.used[cut].sum(1) > 5).all()  # rise and fall are
    relative = half.held["corrected"].peak_error[~cut]
    assert half.gap["corrected"].peak_rms_percent == pytest.approx(100 * np.sqrt((relative**2).mean()))


@pytest.mark.long
def test_a_range_that_is_known_takes_nothing_from_the_verdict(
    gravity_set: GapDataset, diagnosed: Diagnosis, half: Diagnosis
) -> None:
    """The same cause and parameters as without a limit, each within its interval; readings at it are bounds."""
    limit = max(t.phase.cut_off or 0.0 for t in half.quality.trials if t.phase)
    stated = replace(gravity_set, measurement=replace(gravity_set.measurement, range_n=limit))
    with few_explanations(KEPT, CURVES):
        d = diagnose(cut_off(stated, 0.55))
    assert d.verdict == diagnosed.verdict == "identified" and d.scored[0].explanation == ("gravity",)
    assert d.scored[0].probability == pytest.approx(diagnosed.scored[0].probability, abs=0.03)
    assert d.highest == 1.0 and doubts(d) == doubts(diagnosed)
    assert d.observations.censored is not None and d.observations.censored.sum() > 0.1 * d.observations.n_used
    std = np.sqrt(np.diag(d.corrected.covariance))
    assert (np.abs(d.corrected.theta - diagnosed.corrected.theta) < 2 * std).all()
    held = d.held["corrected"].measured_peak
    assert 0.2 < np.isnan(held).mean() < 0.8
    assert any("the end of the sensor's range is reached in" in line for line in d.warnings)


def test_peaks_beyond_a_known_range_are_bounds_to_the_end(
    gravity_set: GapDataset, half: Diagnosis, tmp_path: Path
) -> None:
    """Peaks alone, half of them at the range's end: everything that follows goes on without them."""
    limit = max(t.phase.cut_off or 0.0 for t in half.quality.trials if t.phase)
    stated = replace(gravity_set.measurement, range_n=limit)
    trials = tuple(replace(t, trace=None) for t in cut_off(gravity_set, 0.55).trials)
    with few_explanations(KEPT, CURVES):
        d = diagnose(replace(gravity_set, measurement=stated, trials=trials))
    assert d.observations.censored is not None and d.excluded == {}
    at_end = d.observations.censored[:, 0]
    assert 0.2 < at_end.mean() < 0.8 and np.array_equal(np.isnan(d.held["corrected"].measured_peak), at_end)
    fitted = d.fits[0].linearised().predicted
    of = d.observations.condition
    read = [not at_end[of == c].all() for c in np.unique(of)]  # a trial at the end hides no others
    assert [c.share > 0 for c in d.gap_map.conditions] == read
    assert (fitted[~at_end] > 0).all() and d.gap["recalibrated"].peak_rms_percent is not None
    write_report(tmp_path / "report.html", d, document(d))
    assert "≥" in (tmp_path / "report.html").read_text()


def test_two_faulty_repeats_change_nothing(gravity_set: GapDataset, diagnosed: Diagnosis) -> None:
    """Each lost the same reading before contact; the noise is to be told from the samples."""
    free = replace(gravity_set, measurement=replace(gravity_set.measurement, force_noise_std_n=None))
    pair = max(free.conditions.values(), key=len)[:2]
    assert len(pair) == 2
    trials = list(free.trials)
    for i in pair:
        trace = trials[i].trace
        assert trace is not None
        force = trace.force.copy()
        force[int(np.searchsorted(trace.time, -0.0015))] = -9999.0
        trials[i] = replace(trials[i], trace=replace(trace, force=force))
    spoilt, whole = assess_dataset(replace(free, trials=tuple(trials))), assess_dataset(free)
    assert spoilt.excluded == whole.excluded and spoilt.damaged == ()
    assert spoilt.noise.std == pytest.approx(whole.noise.std, rel=0.05)
    one, other = observe(spoilt), observe(whole)
    assert one.names == other.names and np.array_equal(one.force, other.force)  # so is all that follows


def test_held_readings_are_compared_once(gravity_set: GapDataset) -> None:
    def held(trial: Trial) -> Trial:
        assert trial.trace is not None
        every = np.arange(trial.trace.force.size) // 4 * 4
        return replace(trial, trace=replace(trial.trace, force=trial.trace.force[every]))

    slow = observe(assess_dataset(replace(gravity_set, trials=tuple(map(held, gravity_set.trials)))))
    full = observe(assess_dataset(gravity_set))
    assert slow.interval == pytest.approx(4 * full.interval)
    for i in range(len(slow.names)):
        there = np.isin(np.round(full.time[i], 9), np.round(slow.time[i, slow.used[i]], 9)) & full.used[i]
        kept = np.isin(np.round(slow.time[i], 9), np.round(full.time[i, there], 9)) & slow.used[i]
        assert there.sum() > 0.2 * full.used[i].sum()
        assert full.force[i, there] == pytest.approx(
            slow.force[i, kept], abs=0.2
        )  # but for the sensor's zero


@pytest.mark.parametrize("offset", [-300.0, 20.0])
def test_an_untared_sensor_changes_nothing(gravity_set: GapDataset, offset: float) -> None:
    def untared(trial: Trial) -> Trial:
        assert trial.trace is not None
        return replace(trial, trace=replace(trial.trace, force=trial.trace.force + offset), peak_force=None)

    shifted = assess_dataset(replace(gravity_set, trials=tuple(map(untared, gravity_set.trials))))
    whole = assess_dataset(gravity_set)
    assert shifted.excluded == whole.excluded and shifted.doubts == whole.doubts
    one, other = observe(shifted), observe(whole)
    assert one.names == other.names and one.force == pytest.approx(other.force, abs=0.3)

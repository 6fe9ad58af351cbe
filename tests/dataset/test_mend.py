"""Damage that is undone, left out or told, on made-up trials: what is held, lost, not zeroed or cut off."""

from dataclasses import replace

import numpy as np
import pytest
from impacts import CONDITIONS, RIG, made_up, sampled, with_force, with_trial

from acf_jax.dataset import Measurement, Trace, Trial, assess_dataset, faults, look, lost
from acf_jax.dataset.held import held_for
from acf_jax.dataset.look import assess
from acf_jax.dataset.noise import quantisation_step


def held(trial, times, phase=0.0):
    """`trial` as a recorder keeps it that asks `times` as often as the sensor measures."""
    force = trial.trace.force
    reading = np.floor((np.arange(force.size) + phase) / times)
    first = np.ceil(reading * times - phase).astype(int).clip(0)
    return with_force(trial, force[first])


@pytest.mark.parametrize("times", [1.9, 2.5, 3.3])
def test_readings_held_for_no_whole_number_of_samples_are_thinned_out(times):
    dataset = made_up(0, end=0.03)
    quality = assess_dataset(replace(dataset, trials=tuple(held(t, times) for t in dataset.trials)))
    assert any("each reading is held for" in w and "all 20 trials" in w for w in quality.doubts)
    for trial, mended in zip(dataset.trials, quality.dataset.trials, strict=True):
        assert mended.trace.force.size == pytest.approx(trial.trace.force.size / times, rel=0.1)
        assert np.isin(mended.trace.force, trial.trace.force).all()
    assert quality.excluded == {} and quality.damaged == ()


@pytest.mark.parametrize("times", [2, 3, 4, 8])
@pytest.mark.parametrize("options", [{}, {"step": 0.5}, {"share": 0.6}], ids=["white", "coarse", "coloured"])
def test_held_readings_are_thinned_out(times, options):
    dataset = made_up(0, end=0.03, **options)
    trials = tuple(held(t, times) for t in dataset.trials)
    quality = assess_dataset(replace(dataset, trials=trials))
    for trial, mended in zip(dataset.trials, quality.dataset.trials, strict=True):
        rate = 1 / np.median(np.diff(mended.trace.time))
        assert rate == pytest.approx(8000 / times)
        at = np.searchsorted(trial.trace.time, mended.trace.time - 1e-9)
        assert np.array_equal(trial.trace.force[at], mended.trace.force)  # readings as they were when new
        assert mended.trace.force.size > 0.8 * trial.trace.force.size / times
    assert quality.excluded == {} and quality.damaged == ()
    assert any(f"each reading is held for {times:g}" in w and "all 20 trials" in w for w in quality.doubts)


@pytest.mark.parametrize("options", [
    {}, {"std": 0.02, "step": 2.0}, {"std": 1.0, "step": 4.0}, {"std": 0.0, "step": 0.0}, {"share": 0.9},
    {"rate": 4e4, "std": 0.1, "step": 0.5},
    pytest.param({"rate": 1e5, "std": 0.1, "step": 0.5}, marks=pytest.mark.long), {"rate": 1000.0},
    {"rate": 1000.0, "step": 0.5, "end": 0.03},
    {"rate": 1000.0, "std": 0.02}, {"repeats": 1}, {"step": 1.0}, {"std": 0.02, "end": 0.03}, {"std": 2.0, "step": 5.0},
])  # fmt: skip
def test_nothing_is_mended_where_nothing_is_wrong(options):
    for seed in range(2):
        dataset = made_up(seed, stated=False, **options)
        quality = assess_dataset(dataset)
        assert quality.doubts == () and quality.damaged == ()
        assert all(a is b for a, b in zip(dataset.trials, quality.dataset.trials, strict=True))


def test_readings_held_in_some_trials_are_told_by_name():
    dataset = made_up(0)
    quality = assess_dataset(with_trial(dataset, 6, held(dataset.trials[6], 4)))
    assert "each reading is held for 4 samples in 1 of 20 trials (t006)" in quality.doubts[0]
    assert quality.excluded == {} and quality.trials[6].sample_rate == pytest.approx(2000.0)
    assert quality.trials[5].sample_rate == pytest.approx(8000.0)


def test_a_slow_ramp_in_steps_is_not_held():
    assert held_for(np.round(np.linspace(0, 30, 400) ** 1.3)) == 1.0


def spoilt(trial, at, values):
    """`trial` with other readings from index `at` on, its peak column as a recorder would write it."""
    force = trial.trace.force.copy()
    force[at : at + len(values)] = values
    return with_force(trial, force)


def index(trial, time):
    return int(np.searchsorted(trial.trace.time, time - 1e-9))


PLACES = {"first": -0.003, "approach": -0.0015, "rise": 0.001, "peak": 0.0035, "fall": 0.006}


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("readings", [[-9999.0], [-9999.0] * 3, [9999.0], [65535.0, 65535.0]])
def test_lost_readings_are_taken_out_and_the_trial_is_kept(place, readings):
    dataset = made_up(0)
    trial = dataset.trials[6]
    at = index(trial, PLACES[place])
    quality = assess_dataset(with_trial(dataset, 6, spoilt(trial, at, readings)))
    gone = range(at, at + len(readings))
    left = quality.dataset.trials[6].trace
    assert np.array_equal(left.time, np.delete(trial.trace.time, gone))
    assert np.array_equal(left.force, np.delete(trial.trace.force, gone))
    assert quality.excluded == {} and quality.damaged == ()
    assert quality.noise.std == 1.0 and abs(quality.trials[6].phase.peak_force - 265) < 3
    assert f"lost reading{'s are' if len(readings) > 1 else ' is'} taken out of 1 of 20" in quality.doubts[0]


def test_a_lost_last_reading_is_taken_out():
    dataset = made_up(0, end=0.006)  # in contact to the end
    trial = dataset.trials[6]
    quality = assess_dataset(with_trial(dataset, 6, spoilt(trial, trial.trace.force.size - 1, [0.0])))
    assert np.array_equal(quality.dataset.trials[6].trace.force, trial.trace.force[:-1])
    assert quality.excluded == {}


@pytest.mark.parametrize("value", ["zero", "the last one"])
def test_a_reading_of_zero_or_of_the_last_one_again_is_lost(value):
    dataset = made_up(0, std=0.05)
    for i in (4, 8, 16):
        trial = dataset.trials[i]
        at = index(trial, 0.0015)  # the force rises steeply
        reading = 0.0 if value == "zero" else trial.trace.force[at - 1]
        quality = assess_dataset(with_trial(dataset, i, spoilt(trial, at, [reading])))
        assert np.array_equal(quality.dataset.trials[i].trace.time, np.delete(trial.trace.time, at))
        assert quality.excluded == {}


@pytest.mark.parametrize("time", [-0.0015, 0.003])
@pytest.mark.parametrize("reading", [-9999.0, 0.0, 65535.0])
def test_both_repeats_may_lose_the_same_reading(time, reading):
    """At the same time with the same digits: no rig does that."""
    dataset = made_up(0, stated=False)
    trials = list(dataset.trials)
    for i in dataset.conditions[(0.2, 60.0)]:
        trials[i] = spoilt(trials[i], index(trials[i], time), [reading])
    quality = assess_dataset(replace(dataset, trials=tuple(trials)))
    assert quality.excluded == {} and quality.damaged == ()
    assert 0.85 < quality.noise.std < 1.15
    if reading or time > 0:  # before contact the sensor reads nothing anyway
        assert "2 lost readings are taken out of 2 of 20 trials" in quality.doubts[0]


def test_a_reading_lost_in_many_trials():
    rng = np.random.default_rng(0)
    dataset = made_up(0, stated=False)
    trials = tuple(
        spoilt(t, int(rng.integers(4, t.trace.force.size - 4)), [-9999.0]) for t in dataset.trials[:16]
    )
    quality = assess_dataset(replace(dataset, trials=trials + dataset.trials[16:]))
    assert quality.excluded == {} and quality.damaged == ()
    assert 0.85 < quality.noise.std < 1.15
    assert "16 lost readings are taken out of 16 of 20 trials" in quality.doubts[0]


def test_a_burst_is_taken_out_as_well():
    dataset = made_up(0)
    trial = dataset.trials[6]
    at = index(trial, 0.002)
    burst = trial.trace.force[at : at + 5] + 60.0 * np.array([1, 0, 1, 0, 1])
    quality = assess_dataset(with_trial(dataset, 6, spoilt(trial, at, burst)))
    assert np.array_equal(
        quality.dataset.trials[6].trace.force, np.delete(trial.trace.force, [at, at + 2, at + 4])
    )


def test_a_trial_that_lost_many_readings_is_left_out():
    dataset = made_up(0)
    trial = dataset.trials[6]
    force = trial.trace.force.copy()
    force[30::9] = -9999.0
    quality = assess_dataset(with_trial(dataset, 6, with_force(trial, force)))
    assert list(quality.excluded) == ["t006"] and "readings are lost" in quality.excluded["t006"]


@pytest.mark.parametrize("every, passes", [(200, 2), (15, 6)])
def test_readings_lost_far_apart_are_taken_out_in_one_pass(every, passes, monkeypatch):
    """A pass takes as long as the trace; of a trial that lost too many no more are looked for."""
    trace = sampled(0.2, 60.0, np.random.default_rng(0), rate=5e4, end=0.2)
    force, at, looked = trace.force.copy(), np.arange(30, trace.force.size - 30, every), []
    force[at] = -9999.0
    monkeypatch.setattr(lost, "_Rest", lambda *given, real=lost._Rest: looked.append(1) or real(*given))
    ((left, gone),) = lost.without_lost([Trace(trace.time, force)], [[0]])
    assert len(looked) <= passes
    if every == 200:
        assert np.array_equal(left.time, np.delete(trace.time, at))
        assert [x.time for x in gone] == trace.time[at].tolist()
    else:
        assert lost.MOST * trace.time.size < len(gone) < at.size


def test_the_step_of_readings_is_told_once_a_trace(monkeypatch):
    """Not for each of a thousand runs of equal readings."""
    told = []
    for module in (look, faults):
        monkeypatch.setattr(
            module, "quantisation_step", lambda force: told.append(1) or quantisation_step(force)
        )
    trace = sampled(0.2, 60.0, np.random.default_rng(0), rate=2e6, step=0.5, std=0.01)
    assert np.count_nonzero(np.diff(trace.force) == 0.0) > 1000
    assess(Trial("a", 0.2, 60.0, None, trace), RIG.impact_time, 1.0)
    assert len(told) == 2  # of the trace and of its impact


@pytest.mark.parametrize("offset", [-300.0, 20.0])
def test_an_untared_sensor_is_told_and_nothing_else(offset):
    dataset = made_up(0, end=0.006)
    trials = tuple(with_force(t, t.trace.force + offset) for t in dataset.trials)
    quality = assess_dataset(replace(dataset, trials=trials))
    assert quality.excluded == {} and quality.doubts == ()
    assert (
        quality.warnings[0] == f"the sensor reads {offset:+.3g} N before contact; zero it before each trial"
    )
    assert all(warning.startswith("contact is lost within the trace") for warning in quality.warnings[1:])
    assert quality.noise.offset == pytest.approx(offset, abs=0.3)
    stated = tuple(replace(t, peak_force=t.peak_force - offset) for t in trials)  # as if it had been tared
    assert assess_dataset(replace(dataset, trials=stated)).excluded == {}


def test_a_trial_that_alone_was_not_zeroed_is_zeroed():
    dataset = made_up(0, stated=False)
    trial = dataset.trials[6]
    quality = assess_dataset(with_trial(dataset, 6, with_force(trial, trial.trace.force + 20.0)))
    assert quality.excluded == {} and quality.damaged == ()
    assert 0.85 < quality.noise.std < 1.15 and quality.noise.is_white and abs(quality.noise.offset) < 0.3
    assert np.abs(quality.dataset.trials[6].trace.force - trial.trace.force).max() < 1.0
    assert "t006 +19.8 N" in quality.doubts[0]


def test_a_peak_that_was_stated_zeroed_stays():
    """Only a peak as the trace reads it has the odd zero, too."""
    dataset = made_up(0, stated=False)
    trial = dataset.trials[6]
    read = with_force(trial, trial.trace.force + 40.0)
    for stated in (trial.peak_force, read.peak_force):
        quality = assess_dataset(with_trial(dataset, 6, replace(read, peak_force=stated)))
        assert quality.excluded == {}
        assert quality.dataset.trials[6].peak_force == pytest.approx(trial.peak_force, abs=1.0)


def test_one_trial_does_not_make_the_noise_of_all():
    dataset = made_up(0, stated=False)
    rng = np.random.default_rng(0)
    trial = dataset.trials[6]
    noisy = with_force(trial, trial.trace.force + rng.normal(0, 100.0, trial.trace.force.size))
    quality = assess_dataset(with_trial(dataset, 6, noisy))
    assert 0.85 < quality.noise.std < 1.15
    assert list(quality.excluded) == ["t006"] and "scatters by" in quality.excluded["t006"]


def test_a_wrong_label_does_not_make_the_noise_of_peaks():
    dataset = made_up(0, stated=False, spread=0.0)
    peaks = [replace(t, trace=None) for t in dataset.trials]
    usual = assess_dataset(replace(dataset, trials=tuple(peaks))).noise
    peaks[6] = replace(peaks[6], peak_force=2 * peaks[6].peak_force)
    noise = assess_dataset(replace(dataset, trials=tuple(peaks))).noise
    assert usual.source == noise.source == "repeats"
    assert 0.2 < usual.std < 1.2 and noise.std < 1.2


def clipped(dataset, limit_of, some=None):
    trials = tuple(
        with_force(t, np.minimum(t.trace.force, limit_of(t))) if some is None or i in some else t
        for i, t in enumerate(dataset.trials)
    )
    return replace(dataset, trials=trials)


def test_what_is_cut_off_is_named_and_no_peak():
    dataset = clipped(made_up(0), lambda t: 200.0)
    quality = assess_dataset(dataset)
    expected = [t.name for t in made_up(0).trials if t.trace.force.max() > 200]
    assert quality.excluded == {} and sorted(quality.damaged) == expected and len(expected) == 8
    assert "the force is cut off at 200 N in 8 of 20 trials (t006, t007" in quality.doubts[0]
    assert [t.name for t in quality.trials if t.phase.cut_off == 200.0] == expected
    assert not any("faulty" in line or "repeats at" in line for line in quality.warnings)


def test_each_trial_may_be_cut_off_at_a_level_of_its_own():
    dataset = clipped(made_up(0), lambda t: np.round(0.6 * t.trace.force.max(), 1))
    quality = assess_dataset(dataset)
    assert quality.excluded == {}
    assert len(quality.damaged) == 20 and all(t.phase.cut_off for t in quality.trials)
    assert "in 20 of 20 trials" in quality.doubts[0] and len(quality.doubts) == 1


def test_one_condition_may_reach_the_range():
    quality = assess_dataset(clipped(made_up(0), lambda t: 309.0))
    assert sorted(quality.damaged) == ["t018", "t019"] and quality.excluded == {}


def test_a_trial_that_is_cut_off_below_what_others_read_is_faulty():
    quality = assess_dataset(clipped(made_up(0), lambda t: 200.0, [8]))
    assert list(quality.excluded) == ["t008"] and "which other trials exceed" in quality.excluded["t008"]


def test_a_higher_peak_of_another_instrument_is_no_wrong_label():
    dataset = clipped(made_up(0), lambda t: 200.0)
    trials = list(dataset.trials)
    trials[8] = replace(trials[8], peak_force=305.0)
    assert assess_dataset(replace(dataset, trials=tuple(trials))).excluded == {}


def test_peaks_that_are_equal_to_the_digit_are_cut_off():
    dataset = made_up(0)
    peaks = tuple(replace(t, trace=None, peak_force=min(t.peak_force, 200.0)) for t in dataset.trials)
    quality = assess_dataset(replace(dataset, trials=peaks))
    assert quality.excluded == {} and len(quality.damaged) == 8
    assert sum(look.peak_is_bound for look in quality.trials) == 8
    assert quality.doubts[0].startswith("the force is cut off at 200 N in 8 of 20 trials (t006, t007")
    whole = tuple(replace(t, trace=None, peak_force=round(t.peak_force)) for t in dataset.trials)
    quality = assess_dataset(replace(dataset, trials=whole))
    assert quality.excluded == {} and not any(look.peak_is_bound for look in quality.trials)


def test_a_flat_top_to_the_end_of_the_trace_is_cut_off():
    dataset = made_up(0, end=0.004)
    dataset = clipped(dataset, lambda t: 150.0)
    quality = assess_dataset(dataset)
    assert {t.name for t in quality.trials if t.phase.cut_off} == {
        t.name for t in made_up(0, end=0.004).trials if t.trace.force.max() > 160
    }


def test_the_noise_as_stated_is_doubted_before_all_else():
    quality = assess_dataset(replace(made_up(0), measurement=Measurement(0.3)))
    assert "force_noise_std_n is stated as 0.3 N" in quality.doubts[0]


def test_few_samples_are_left_as_they_are():
    time = np.arange(-3, 6) / 1000.0
    dataset = made_up(0, conditions=CONDITIONS[:4])
    trials = tuple(replace(t, trace=Trace(time, np.where(time < 0, 0.0, 50.0 + t.contact_velocity)), peak_force=None)
                   for t in dataset.trials)  # fmt: skip
    assert assess_dataset(replace(dataset, trials=trials)).dataset.trials == trials

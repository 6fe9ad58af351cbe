"""Data quality on made-up trials whose truth is known: noise, impact phase, sampling, faulty trials."""

from dataclasses import replace

import numpy as np
import pytest
from impacts import CONDITIONS, K_C, K_F, M, contact_force, made_up, sampled, with_force, with_trial

from acf_jax.dataset import Measurement, Trace, assess, assess_dataset
from acf_jax.dataset.faults import peak_disagreement
from acf_jax.dataset.noise import Noise, difference_noise, fit_noise, look_at_approach, quantisation_step
from acf_jax.dataset.phase import find_impact, moving_mean
from acf_jax.errors import InputError

IMPACT_TIME = float(np.pi * np.sqrt(M / (K_F + K_C)))


def traces(count, seed, **options):
    rng = np.random.default_rng(seed)
    return [sampled(0.2, 60.0, rng, **options) for _ in range(count)]


def test_white_noise_is_called_white():
    fits = [fit_noise(traces(20, seed, std=1.3)) for seed in range(60)]
    assert sum(not fit.is_white for fit in fits) <= 1  # 0 of 200 when measured; 1 % allowed
    stds = np.array([fit.std for fit in fits])
    assert abs(stds.mean() / 1.3 - 1.0) < 0.02
    assert stds.std() / 1.3 < 2.0 * (2 * fits[0].samples) ** -0.5


@pytest.mark.parametrize(("share", "tau"), [(0.45, 8e-4), (0.999, 2e-4)])
def test_coloured_noise_is_measured(share, tau):
    fits = [fit_noise(traces(20, seed, std=1.0, share=share, tau=tau)) for seed in range(20)]
    assert sum(not fit.is_white for fit in fits) >= 19
    assert abs(np.mean([fit.std for fit in fits]) - 1.0) < 0.03
    assert abs(np.median([fit.share for fit in fits]) - share) < 0.12
    assert 0.6 < np.median([fit.correlation_time for fit in fits]) / tau < 1.7


def test_noise_is_independent_of_the_sampling_rate():
    fine = fit_noise(traces(20, 1, share=0.999, tau=8e-4, rate=16000.0))
    coarse = fit_noise(traces(20, 2, share=0.999, tau=8e-4, rate=4000.0))
    assert 0.5 < fine.correlation_time / coarse.correlation_time < 2.0
    assert fine.samples_per_independent(1 / 16000) > 2.0 * coarse.samples_per_independent(1 / 4000)


def test_covariance_of_the_noise():
    noise = fit_noise(traces(20, 3, share=0.5, tau=1e-3))
    covariance = noise.covariance(np.array([0.0, 0.001]))
    np.testing.assert_allclose(np.diag(covariance), noise.std**2)
    expected = noise.share * np.exp(-0.001 / noise.correlation_time)
    assert 0.0 < expected < 1.0
    np.testing.assert_allclose(covariance[0, 1] / noise.std**2, expected)


def test_a_zeroed_sensor_keeps_its_zero():
    time = np.arange(-44, 0) / 8000.0
    found = []
    for seed in range(60):
        forces = np.random.default_rng(seed).standard_normal((10, time.size))
        found.append(
            [fit_noise([Trace(time, force + level) for force in forces], 1.0).offset for level in (0.0, 5.0)]
        )
    zeroed, shifted = np.array(found).T
    by_chance = 400**-0.5  # N, of the mean of what is surely before contact
    assert 0.6 < (zeroed == 0.0).mean() < 0.8
    assert np.sqrt((zeroed**2).mean()) < 0.7 * by_chance
    assert np.sqrt(((shifted - 5.0) ** 2).mean()) == pytest.approx(by_chance, rel=0.2)


def test_offset_and_drift_of_the_sensor():
    time = np.arange(-400, 200) / 8000.0
    force = 4.0 + 30.0 * time + np.random.default_rng(0).normal(0.0, 0.2, time.size)
    approach = look_at_approach(Trace(time, force))
    assert abs(approach.drift - 30.0) < 4.0 * approach.drift_std < 10.0
    assert abs(approach.offset - (4.0 - 30.0 * 0.0252)) < 4.0 * 0.2 / approach.samples**0.5
    assert abs(approach.noise_std - 0.2) < 0.03
    assert look_at_approach(Trace(time[395:], force[395:])) is None


def test_noise_without_an_approach_comes_from_third_differences():
    cut = [Trace(t.time[t.time >= 0], t.force[t.time >= 0]) for t in traces(10, 4, std=1.0)]
    assert fit_noise(cut) is None
    assert abs(difference_noise(cut).std - 1.0) < 0.1


def test_quantisation():
    rng = np.random.default_rng(0)
    values = rng.normal(0.0, 5.0, 500)
    assert abs(quantisation_step(np.round(values / 0.05) * 0.05) - 0.05) < 1e-9
    assert quantisation_step(values) == 0.0
    assert quantisation_step(np.ones(5)) == 0.0


@pytest.mark.parametrize(("v", "f_p"), CONDITIONS)
@pytest.mark.parametrize("std", [0.01, 1.0, 2.0])
def test_contact_loss_is_found(v, f_p, std):
    dense = np.linspace(0.0, 0.02, 200001)
    lost = dense[np.flatnonzero(contact_force(dense, v, f_p) == 0.0)[0]]
    rng = np.random.default_rng(0)
    for _ in range(10):
        phase = find_impact(sampled(v, f_p, rng, std=std, end=0.02), std, IMPACT_TIME)
        assert phase.start == 24 and phase.onset == 0.0
        assert abs(phase.contact_lost - lost) < 3.1 / 8000.0
        assert phase.second_contact is None


def test_no_contact_loss_before_the_end_of_the_trace():
    trace = sampled(0.3, 60.0, np.random.default_rng(0), end=0.006)
    phase = find_impact(trace, 1.0, IMPACT_TIME)
    assert phase.contact_lost is None and phase.impulse_ratio is None and phase.stop == trace.time.size


def test_ringing_is_no_contact_loss():
    time = np.arange(-24, 200) / 8000.0
    smooth = contact_force(time, 0.3, 60.0)
    ringing = smooth * (1.0 + 1.2 * np.sin(2 * np.pi * 1900.0 * time))
    assert ringing.min() < -40.0
    plain, rung = (find_impact(Trace(time, force), 0.1, IMPACT_TIME) for force in (smooth, ringing))
    assert abs(plain.contact_lost - rung.contact_lost) < 1e-3


def test_low_saddle_is_no_contact_loss():
    time = np.arange(0, 480) / 8000.0
    force = 65.0 + 60.0 * np.cos(2 * np.pi * time / 0.02)  # down to 5 N and up again
    noisy = force + np.random.default_rng(0).normal(0.0, 1.0, time.size)
    assert find_impact(Trace(time, noisy), 1.0, IMPACT_TIME).contact_lost is None


def leaking(force, time, constant=0.008):
    """What a sensor reads whose charge leaks with a time constant, s."""
    step = time[1] - time[0]
    gone = np.cumsum(force * np.exp(time / constant)) * step / constant * np.exp(-time / constant)
    return force - gone


def test_a_reading_that_falls_through_zero_is_no_contact_loss():
    time = np.arange(-24, 400) / 8000.0
    force = np.where((time >= 0) & (time < 0.008), 200.0 * np.sin(np.pi * time / 0.008), 0.0)
    reading = leaking(force, time) + np.random.default_rng(0).normal(0.0, 0.5, time.size)
    assert reading.min() < -50.0
    until_loss = time < 0.008
    phase = find_impact(Trace(time[until_loss], reading[until_loss]), 0.5, IMPACT_TIME)
    assert phase.contact_lost is None and phase.lowest_force < -50.0
    assert find_impact(Trace(time, reading), 0.5, IMPACT_TIME).contact_lost > 0.008
    honest = find_impact(Trace(time, force + reading - leaking(force, time)), 0.5, IMPACT_TIME)
    assert abs(honest.contact_lost - 0.008) < 3e-4 and honest.lowest_force > -2.0


def test_readings_below_zero_are_named():
    dataset = made_up(0)
    leaking_ones = tuple(with_force(t, leaking(t.trace.force, t.trace.time, 0.02)) for t in dataset.trials)
    warnings = assess_dataset(replace(dataset, trials=leaking_ones)).warnings
    assert any("below zero" in w and leaking_ones[0].name in w for w in warnings)
    untared = tuple(with_force(t, t.trace.force - 500.0) for t in dataset.trials)
    for healthy in (dataset.trials, untared):
        assert not any("below zero" in w for w in assess_dataset(replace(dataset, trials=healthy)).warnings)


def test_second_contact_impulse_and_rebound():
    time = np.arange(-24, 400) / 8000.0
    first = np.where((time >= 0) & (time < 0.008), 200.0 * np.sin(np.pi * time / 0.008), 0.0)
    later = time - 0.02
    second = np.where((later >= 0) & (later < 0.008), 80.0 * np.sin(np.pi * later / 0.008), 0.0)
    phase = find_impact(Trace(time, first + second), 0.1, IMPACT_TIME)
    assert abs(phase.contact_lost - 0.008) < 3e-4
    assert abs(phase.second_contact - 0.02) < 1e-3
    np.testing.assert_allclose(phase.impulse, 200.0 * 0.008 * 2.0 / np.pi, rtol=5e-3)
    np.testing.assert_allclose(phase.impulse_ratio, 1.0, rtol=0.1)
    assert phase.peak_force == pytest.approx(200.0, rel=1e-3)


@pytest.mark.parametrize("rate", [1000.0, 2000.0, 8000.0])
def test_missed_peak_bounds_what_sampling_loses(rate):
    losses, bounds = [], []
    for shift in np.linspace(0.0, 1.0, 11):
        time = (np.arange(-5, round(0.009 * rate)) + shift) / rate
        force = np.where(time > 0, 200.0 * np.sin(np.pi * time / 0.008), 0.0)
        phase = find_impact(Trace(time, force), 0.0, 0.008)
        losses.append(200.0 - phase.peak_force)
        bounds.append(phase.missed_peak)
    worst = 200.0 * (np.pi / 0.008 / rate) ** 2 / 8.0
    assert np.all(np.array(losses) <= np.array(bounds) * 1.05 + 1e-9)
    assert max(bounds) < 1.3 * worst


def test_samples_of_nearly_one_instant_end_no_search():
    time = np.r_[1e-30 * np.arange(20.0), 0.002 + 1e-4 * np.arange(10)]
    assert find_impact(Trace(time, np.full(30, 50.0)), 1.0, IMPACT_TIME).contact_lost is None


def test_moving_mean():
    np.testing.assert_allclose(moving_mean(np.arange(6.0), 3), [0.5, 1, 2, 3, 4, 4.5])


HEALTHY = {
    "nominal": {},
    "quiet": {"std": 0.02, "step": 0.0},
    "coarse readings": {"std": 0.02, "step": 2.0},
    "noisy": {"std": 3.0},
    "coloured": {"share": 0.6},
    "slow sampling": {"rate": 1000.0},
    "past the loss of contact": {"end": 0.03},
    "no repeats": {"repeats": 1},
    "few trials": {"repeats": 1, "conditions": CONDITIONS[:4]},
    "one pretension": {"conditions": CONDITIONS[:5]},
}


@pytest.mark.parametrize("case", HEALTHY)
def test_no_false_alarm(case):
    for seed in range(5):
        quality = assess_dataset(made_up(seed, **HEALTHY[case]))
        assert quality.excluded == {}
        assert len(quality.used) == len(quality.trials)


def test_offset_and_trigger_are_reported_not_excluded():
    dataset = made_up(3)
    trial = dataset.trials[6]
    late = replace(trial, trace=Trace(trial.trace.time + 1 / 8000.0, trial.trace.force))
    quality = assess_dataset(with_trial(dataset, 6, late))
    assert quality.excluded == {}
    assert abs(quality.trials[6].trigger_offset * 8000.0 - 1.0) < 0.3
    assert all(abs(t.trigger_offset) * 8000.0 < 0.5 for i, t in enumerate(quality.trials) if i != 6)
    assert "the trigger is off by a sample or more in t006" in quality.warnings
    for offset in (5.0, -85.0):  # below zero a whole impact may read less than its pretension
        shifted = [with_force(trial, trial.trace.force + offset) for trial in dataset.trials]
        without_peaks = tuple(replace(trial, peak_force=None) for trial in shifted)
        quality = assess_dataset(replace(dataset, trials=without_peaks))
        assert quality.excluded == {}
        assert abs(quality.noise.offset - offset) < 0.2
        assert any("the sensor reads " in warning for warning in quality.warnings)


def relabel(dataset, index, rng, column):
    trial = dataset.trials[index]
    if column == "contact_velocity":
        return replace(
            trial, contact_velocity=rng.choice([v for v, _ in CONDITIONS if v != trial.contact_velocity])
        )
    return replace(trial, pretension=160.0 - trial.pretension)


def change(kind, dataset, index, rng):
    """One trial with a fault."""
    if kind in ("contact_velocity", "pretension"):
        return relabel(dataset, index, rng, kind)
    trial = dataset.trials[index]
    time, force = trial.trace.time, trial.trace.force.copy()
    start = np.searchsorted(time, 0.0)
    held = int(np.count_nonzero(contact_force(time, *trial.condition) > 0.0))
    hit = start + int(held * rng.uniform(0.15, 0.6))
    some, peak = max(6, held // 6), force.max()
    noise = rng.normal(0.0, 1.0, force.size).round(1)
    match kind:
        case "dead":
            force = noise
        case "noisy":
            force = force + 0.15 * peak * noise
        case "dropout":
            force[hit : hit + some] = noise[hit : hit + some]
        case "cable off":
            force[hit:] = noise[hit:]
        case "stuck":
            force[hit : hit + some] = force[hit]
        case "clipped":
            force = np.minimum(force, np.round(0.85 * peak))
        case "wrong range":
            force[start:] *= 0.75
        case "far too large":
            force[start:] *= 10.0
        case "peak column":
            return replace(trial, peak_force=1.3 * trial.peak_force)
    return with_force(trial, force)


KINDS = {
    "dead": "no impact is seen",
    "noisy": "scatters by",
    "dropout": "drops out",
    "cable off": "drops out",
    "stuck": "sticks at",
    "clipped": "is cut off at",
    "wrong range": "differs from the other trials",
    "far too large": "differs from the other trials",
    "contact_velocity": "wrong label? it looks like a trial at",
    "pretension": "wrong label? it looks like a trial at",
    "peak column": "but its trace peaks at",
}


@pytest.mark.parametrize("runs", [6, pytest.param(20, marks=pytest.mark.long)])
@pytest.mark.parametrize("kind", KINDS)
def test_faulty_trial_is_found_named_and_alone(kind, runs):
    rng = np.random.default_rng(7)
    found, named = 0, 0
    for run in range(runs):
        dataset = made_up(run % 4)
        index = int(rng.integers(len(dataset.trials)))
        faulty = change(kind, dataset, index, rng)
        quality = assess_dataset(with_trial(dataset, index, faulty))
        assert set(quality.excluded) <= {faulty.name}
        found += faulty.name in quality.excluded
        named += KINDS[kind] in quality.excluded.get(faulty.name, "")
    assert found >= 0.95 * runs and named >= int(0.85 * runs), (found, named)


def test_a_second_touch_that_jumps_is_no_spike():
    """The force jumps to the pretension again, as at first contact."""
    dataset = made_up(0, end=0.06)

    def touched_again(trial):
        time, force = trial.trace.time, trial.trace.force
        again = contact_force(time - 0.025, 0.3 * trial.contact_velocity, 0.4 * trial.pretension)
        return with_force(trial, force + again)

    quality = assess_dataset(replace(dataset, trials=tuple(map(touched_again, dataset.trials))))
    assert not quality.excluded and not any("faulty" in w for w in quality.warnings)
    assert all(t.phase.second_contact is not None for t in quality.trials)


def test_a_peak_behind_a_force_that_nearly_vanished_is_no_wrong_label():
    """Whether contact was lost there is open, so the peak may be that of the whole trace."""
    trial = made_up(0).trials[6]
    time, force = trial.trace.time, trial.trace.force
    held = np.count_nonzero(contact_force(time, *trial.condition) > 0.0)
    behind = np.maximum(np.arange(time.size) - np.searchsorted(time, 0.0) - held - 8, 0)
    risen = with_force(trial, force + 1.4 * force.max() * np.sin(np.minimum(behind / held, 1.0) * np.pi))
    phase = find_impact(risen.trace, 1.0, IMPACT_TIME)
    later = float(risen.trace.force.max())
    assert later > 1.2 * phase.peak_force
    assert peak_disagreement(replace(risen, peak_force=later), phase, 1.0) == []
    assert peak_disagreement(replace(risen, peak_force=phase.peak_force), phase, 1.0) == []
    assert peak_disagreement(replace(risen, peak_force=1.3 * later), phase, 1.0) != []


def test_a_wrong_label_is_told_where_it_belongs():
    dataset = made_up(0)
    wrong = replace(dataset.trials[6], contact_velocity=0.1)
    (reason,) = assess_dataset(with_trial(dataset, 6, wrong)).excluded.values()
    assert "it looks like a trial at 0.3 m/s and 60 N" in reason


def test_faults_that_many_trials_share_exclude_none():
    dataset = made_up(0)
    rng = np.random.default_rng(0)
    faulty = tuple(change("dropout", dataset, i, rng) for i in range(8)) + dataset.trials[8:]
    quality = assess_dataset(replace(dataset, trials=faulty))
    assert quality.excluded == {} and set(quality.damaged) == {t.name for t in faulty[:8]}
    assert any("look faulty, too many to leave out" in line for line in quality.doubts)


def test_peaks_only():
    dataset = made_up(0)
    peaks = replace(dataset, trials=tuple(replace(trial, trace=None) for trial in dataset.trials))
    quality = assess_dataset(peaks)
    assert quality.excluded == {} and quality.noise.std == 1.0 and quality.noise.source == "stated"
    for factor in (0.6, 10.0, 1e6):
        wrong = replace(peaks.trials[9], peak_force=factor * peaks.trials[9].peak_force)
        assert list(assess_dataset(with_trial(peaks, 9, wrong)).excluded) == ["t009"]
    unknown = replace(peaks, measurement=Measurement())
    assert assess_dataset(unknown).noise.source == "repeats"
    single = replace(unknown, trials=unknown.trials[::2])
    assert assess_dataset(single).noise.source == "assumed"
    assert any("is unknown and assumed" in warning for warning in assess_dataset(single).warnings)


def test_noise_stated_wrongly_is_said():
    dataset = made_up(0, std=1.0)
    claimed = replace(dataset, measurement=Measurement(0.3))
    quality = assess_dataset(claimed)
    assert quality.noise.std == 0.3
    assert any("force_noise_std_n is stated as 0.3 N" in warning for warning in quality.warnings)
    assert assess_dataset(made_up(0, stated=False)).noise.source == "approach"


def test_one_trial_by_itself():
    quality = assess(made_up(0).trials[8], IMPACT_TIME)
    assert quality.faults == () and quality.sample_rate == pytest.approx(8000.0)
    assert quality.quantisation == pytest.approx(0.05)
    assert 0.5 < quality.approach.noise_std < 1.6
    peak = contact_force(np.linspace(0, 0.012, 20001), 0.35, 60.0).max()
    assert quality.phase.peak_force == pytest.approx(peak, rel=0.02)


def test_one_faulty_trial_among_hundreds():
    dataset = made_up(0)
    many = tuple(replace(t, name=f"{t.name}-{k}") for k in range(15) for t in dataset.trials)
    dataset = with_trial(replace(dataset, trials=many), 123, replace(many[123], pretension=100.0))
    assert many[123].pretension == 60.0
    assert list(assess_dataset(dataset).excluded) == [many[123].name]


def test_repeats_of_two_pretensions_under_one_label_are_told():
    """Half of the trials had 60 N, half 100 N, and nobody wrote it down: too many to call them faulty."""
    mixed = [made_up(0, repeats=1, conditions=[(v, f_p) for v, _ in CONDITIONS]) for f_p in (60.0, 100.0)]
    trials = [replace(t, name=f"{k}-{t.name}", pretension=60.0) for k in (0, 1) for t in mixed[k].trials]
    warnings = assess_dataset(replace(mixed[0], trials=tuple(trials))).warnings
    assert any("repeats at 0.05 m/s and 60 N peak between" in w and "check velocity" in w for w in warnings)
    for seed in range(6):
        assert not any("repeats at" in w for w in assess_dataset(made_up(seed, repeats=3)).warnings)


def spiked(trial, at, by=400.0):
    """`trial` with a spike of three samples."""
    force = trial.trace.force.copy()
    force[at : at + 3] += by
    return with_force(trial, force)


@pytest.mark.parametrize("repeats", [2, 6])
def test_a_shape_that_repeats_share_is_the_rig(repeats):
    dataset = made_up(0, repeats=repeats)
    group = list(dataset.conditions.values())[4]
    trials = tuple(spiked(t, 50) if i in group else t for i, t in enumerate(dataset.trials))
    quality = assess_dataset(replace(dataset, trials=trials))
    assert quality.excluded == {} and quality.damaged == () and quality.doubts == ()
    assert all(
        np.array_equal(t.trace.force, s.trace.force)
        for t, s in zip(trials, quality.dataset.trials, strict=True)
    )


def test_two_repeats_that_are_faulty_in_different_ways_are_faults():
    dataset = made_up(0)
    first, second = list(dataset.conditions.values())[4]
    rng = np.random.default_rng(0)
    trials = list(dataset.trials)
    trials[first] = change("dropout", dataset, first, rng)
    trials[second] = change("stuck", dataset, second, rng)
    quality = assess_dataset(replace(dataset, trials=tuple(trials)))
    assert set(quality.excluded) == {trials[first].name, trials[second].name}


@pytest.mark.parametrize("kind", ["dead", "stuck"])
def test_what_no_rig_does_is_a_fault_of_both_repeats(kind):
    dataset = made_up(0)
    group = list(dataset.conditions.values())[4]
    trials = list(dataset.trials)
    for i in group:
        trials[i] = change(kind, dataset, i, np.random.default_rng(1))  # at the same time
    quality = assess_dataset(replace(dataset, trials=tuple(trials)))
    assert set(quality.excluded) == {trials[i].name for i in group}


def test_repeats_that_are_mislabelled_alike_are_faults_where_another_condition_explains_them():
    dataset = made_up(0)
    group = dataset.conditions[(0.3, 60.0)]
    wrong = tuple(replace(t, pretension=100.0) if i in group else t for i, t in enumerate(dataset.trials))
    extra = tuple(replace(t, name=f"{t.name}b") for t in made_up(1).trials[6:8])
    quality = assess_dataset(replace(dataset, trials=wrong + extra))
    assert set(quality.excluded) == {wrong[i].name for i in group}
    assert all("it looks like a trial at 0.3 m/s and 60 N" in reason for reason in quality.excluded.values())


def test_repeats_that_agree_but_not_with_other_conditions_are_kept_and_told():
    """No other condition explains them: a limit that they have gone beyond, or a label that is wrong."""
    dataset = made_up(0)
    group = dataset.conditions[(0.3, 60.0)]
    wrong = tuple(
        replace(t, contact_velocity=0.12) if i in group else t for i, t in enumerate(dataset.trials)
    )
    quality = assess_dataset(replace(dataset, trials=wrong))
    assert quality.excluded == {} and set(quality.damaged) == {wrong[i].name for i in group}
    assert any("t006, t007 agree with the repeats of their condition" in line for line in quality.doubts)


def test_a_stated_size_makes_the_colour_better_known() -> None:
    """Whitened by what was found, true noise has a chi-square of one a sample, nearer to it with the size stated."""
    time = np.arange(400) / 8000.0
    truth = Noise(0.7, 0.999, 3e-4).covariance(time)

    def excess(stated: float | None, seed: int) -> float:
        found = fit_noise(traces(16, seed, std=0.7, share=0.999, tau=3e-4, rate=8000.0), stated)
        assumed = replace(found, std=0.7).covariance(time)
        return float(np.trace(np.linalg.solve(assumed, truth)) / time.size - 1.0)

    free, held = (np.array([excess(stated, seed) for seed in range(12)]) for stated in (None, 0.7))
    assert np.sqrt((held**2).mean()) < 0.75 * np.sqrt((free**2).mean())


def test_a_stated_size_that_the_samples_contradict_is_not_held() -> None:
    noise = fit_noise(traces(20, 3, std=1.0, share=0.999, tau=3e-4), 0.3)
    assert noise.std > 0.7


def changed(dataset, force_of, some=slice(None)):
    """`dataset` with another force, of time and force, in some of its trials."""
    trials = list(dataset.trials)
    trials[some] = [with_force(t, force_of(t.trace.time, t.trace.force)) for t in trials[some]]
    return replace(dataset, trials=tuple(trials))


def padded(time, force):
    return np.where(time < 0.0, 0.0, force)


def within_dead_band(time, force):
    return np.where(np.abs(force) < 5.0, 0.0, force)


SIMULATED = made_up(0, std=0.0, step=0.0, end=0.03)
CONSTANT = {
    "noise-free": (SIMULATED, 1e-4, 0.05),
    "noise-free, never zeroed": (changed(SIMULATED, lambda time, force: force + 5.0), 1e-4, 0.05),
    "coarse": (made_up(0, std=0.05, step=0.5), 0.5 / 12**0.5, 0.2),
    "padded": (changed(made_up(0), padded), 0.85, 1.15),
    "dead band": (changed(made_up(0, end=0.03), within_dead_band), 0.85, 1.15),
}


@pytest.mark.parametrize("case", CONSTANT)
def test_a_constant_approach_tells_nothing_of_the_noise(case):
    dataset, low, high = CONSTANT[case]
    stated = assess_dataset(replace(dataset, measurement=Measurement(0.7)))
    assert stated.noise.is_white and stated.noise.std == 0.7 and stated.noise.source == "stated"
    assert any("does not change before contact in t000" in w and "as stated" in w for w in stated.warnings)
    assert not any("is stated as" in w for w in stated.warnings)
    free = assess_dataset(replace(dataset, measurement=Measurement()))
    assert free.noise.is_white and low <= free.noise.std < high and free.noise.source == "differences"
    assert any("does not change before contact" in w and "; state force_noise" in w for w in free.warnings)
    for quality in (stated, free):
        assert quality.noise.offset == pytest.approx(5.0 * (case == "noise-free, never zeroed"))
        assert quality.excluded == {}


def test_what_is_constant_for_as_long_as_is_looked_at_tells_nothing() -> None:
    force = np.append(np.ones(100), np.zeros(300))
    fit = fit_noise([Trace(np.arange(-400, 0) / 8000.0, force)] * 5)
    assert fit.std == 0.0 and fit.is_white


@pytest.mark.parametrize("share", [0.0, 0.6])
def test_constant_approaches_among_others_do_not_count(share) -> None:
    dataset = made_up(1, share=share, stated=False)
    quality = assess_dataset(changed(dataset, padded, slice(1, None, 2)))
    others = replace(dataset, trials=dataset.trials[::2])
    assert quality.noise == assess_dataset(others).noise
    assert quality.noise.is_white == (share == 0.0)
    assert any("in t001, t003" in w and "from the other trials" in w for w in quality.warnings)


def test_coarse_readings_that_are_equal_by_chance_count() -> None:
    coarse = [Trace(t.time[17:], t.force[17:]) for t in traces(40, 0, std=1.0, step=2.0)]
    assert any(np.ptp(t.force[:3]) == 0.0 for t in coarse)
    assert fit_noise(coarse).samples == 3 * 40


def test_no_noise_is_estimated_below_the_step_of_the_readings() -> None:
    rare = changed(made_up(0, std=0.05, step=0.0), lambda time, force: np.round((force + 0.12) / 0.5) * 0.5)
    noise = assess_dataset(replace(rare, measurement=Measurement())).noise
    assert noise.source == "approach" and noise.std == pytest.approx(0.5 / 12**0.5)
    stated = assess_dataset(replace(rare, measurement=Measurement(0.05)))
    assert stated.noise.std == 0.05
    assert any("readings in steps of 0.5 N err by 0.144 N alone" in w for w in stated.warnings)
    enough = assess_dataset(replace(rare, measurement=Measurement(0.15)))
    assert not any("in steps" in w for w in enough.warnings)


def test_without_any_scatter_the_noise_is_assumed_or_asked_for() -> None:
    same = [replace(t, trace=None, peak_force=100.0) for t in made_up(0).trials]
    dataset = replace(made_up(0, stated=False), trials=tuple(same))
    quality = assess_dataset(dataset)
    assert quality.noise.source == "assumed" and quality.noise.std == 0.5
    nothing = replace(dataset, trials=tuple(replace(t, peak_force=0.0) for t in same[:4]))
    with pytest.raises(InputError, match=r"dataset.yaml: measurement.force_noise_std_n: .*; state it"):
        assess_dataset(nothing)

"""The filter that readings have been through, against SciPy's own, and what is left of noise behind it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfilt, sosfiltfilt

from acf_jax.dataset import LowPass, Noise, Trace, assess_dataset, read_dataset
from acf_jax.dataset.filtered import assess_low_passed
from acf_jax.dataset.low_pass import Filter, low_passed, noise_behind, settling_time, thinned
from acf_jax.errors import InputError
from tests.dataset.impacts import made_up, with_force, with_trial, write

RATE = 8000.0
BOTH = pytest.mark.parametrize(
    "way", [LowPass(300.0, 2), LowPass(300.0, 4), LowPass(300.0, 2, True)], ids=str
)


@BOTH
def test_it_is_scipys_butterworth(way: LowPass) -> None:
    rng = np.random.default_rng(0)
    x = rng.standard_normal((2, 3, 800))
    sections = butter(way.order, way.cutoff_hz, fs=RATE, output="sos")
    found = Filter(way, 1 / RATE)(x)
    assert found.shape == x.shape
    own = sosfiltfilt(sections, x) if way.zero_phase else sosfilt(sections, x)
    ends = int(2 * settling_time(way) * RATE)
    middle = slice(ends, -ends) if way.zero_phase else slice(None)
    assert found[..., middle] == pytest.approx(own[..., middle], abs=0.01 if way.zero_phase else 1e-12)


@BOTH
def test_what_had_always_been_stays(way: LowPass) -> None:
    assert Filter(way, 1 / RATE)(np.full(200, 7.0), before=7.0) == pytest.approx(np.full(200, 7.0))


@BOTH
def test_the_gain_of_noise_and_its_independence(way: LowPass) -> None:
    noise = np.random.default_rng(1).standard_normal(200_000)
    one = Filter(way, 1 / RATE)
    left = one(noise)
    assert left.std() == pytest.approx(one.gain, rel=0.02)
    assert one.stride == 13
    kept = left[:: one.stride]
    assert abs(np.corrcoef(kept[1:], kept[:-1])[0, 1]) < 0.2 < np.corrcoef(left[2:], left[:-2])[0, 1]


def test_above_what_is_sampled_nothing_is_filtered() -> None:
    x = np.random.default_rng(0).standard_normal(50)
    assert np.array_equal(Filter(LowPass(3900.0), 1 / RATE)(x), x)


def test_a_clock_that_is_uneven_is_made_even() -> None:
    trace = made_up(0).trials[5].trace
    assert trace is not None
    gap = np.delete(np.arange(trace.time.size), [40, 41])
    whole, short = (
        low_passed(t, LowPass(300.0, 4)) for t in (trace, Trace(trace.time[gap], trace.force[gap]))
    )
    assert np.array_equal(whole.time, trace.time) and short.time == pytest.approx(whole.time, abs=1e-9)
    assert np.abs(short.force - whole.force).max() < 3.0


@pytest.mark.parametrize("zero_phase", [False, True])
def test_the_noise_behind_a_filter_is_told_from_samples_that_do_not_know_of_the_contact(
    zero_phase: bool,
) -> None:
    way, rng = LowPass(300.0, 2, zero_phase), np.random.default_rng(2)
    time = np.arange(-400, 200) / RATE
    traces = []
    for _ in range(12):
        force = np.where(time < 0, 0.0, 100.0) + 0.7 + rng.standard_normal(time.size)
        filtered = Filter(way, 1 / RATE)(force, 0.7)
        traces.append(Trace(time, filtered))
    noise = noise_behind(traces, way)
    assert noise is not None
    assert noise.std == pytest.approx(Filter(way, 1 / RATE).gain, rel=0.15)
    assert noise.offset == pytest.approx(0.7, abs=4 * noise.offset_std) and 0 < noise.offset_std < 0.05
    assert noise.samples == pytest.approx(12 * 396 / 13, rel=0.15)
    assert noise_behind([Trace(time[398:], traces[0].force[398:])], way) is None


def test_samples_that_count_are_the_same_in_repeats() -> None:
    time = np.arange(-24, 112) / RATE
    way = LowPass(400.0)
    late = [thinned(Trace(time[k:], time[k:]), way).time for k in (0, 1, 5)]
    assert np.diff(late[0]) == pytest.approx(np.full(len(late[0]) - 1, 10 / RATE))
    for one in late:
        assert np.isin(one, late[0]).all() and 0.0 in one


def test_the_filter_is_stated_and_told(tmp_path) -> None:  # type: ignore[no-untyped-def]
    folder = write(tmp_path / "set")
    path = folder / "dataset.yaml"
    plain = path.read_text()
    path.write_text(plain + "  low_pass: {cutoff_hz: 400, order: 3, zero_phase: true}\n")
    dataset = read_dataset(folder)
    assert dataset.measurement.low_pass == LowPass(400.0, 3, True)
    assert any(
        "low-passed at 400 Hz (Butterworth, order 3, forw" in x for x in assess_dataset(dataset).warnings
    )
    path.write_text(plain + "  low_pass: {cutoff_hz: 400}\n")
    assert read_dataset(folder).measurement.low_pass == LowPass(400.0, 2, False)


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        (
            "{cutoff_hz: 5000}",
            "low_pass: cutoff_hz is 5000 Hz, but trial 't000' is sampled at 8000 Hz; give less",
        ),
        ("{cutoff_hz: 60}", "leaves less than two samples of an impact of 7.8 ms; give at least 128 Hz"),
        ("{cutoff_hz: 0.4}", "low_pass.cutoff_hz: must be at least 1 Hz, but is 0.4; if it is in kHz"),
        ("{cutoff_hz: .inf}", "low_pass.cutoff_hz"),
        ("{cutoff_hz: 400, order: 0}", "low_pass.order"),
        ("{cutoff_hz: 400, order: 2.5}", "low_pass.order"),
        ("{cutoff_hz: 400, zero_phase: 1}", "low_pass.zero_phase"),
        ("{cutoff: 400}", "low_pass.cutoff_hz: is missing"),
        ("400", "measurement.low_pass"),
    ],
)
def test_faults_of_a_stated_filter(tmp_path, stated, message) -> None:  # type: ignore[no-untyped-def]
    folder = write(tmp_path / "set")
    path = folder / "dataset.yaml"
    path.write_text(path.read_text() + f"  low_pass: {stated}\n")
    with pytest.raises(InputError) as error:
        read_dataset(folder)
    assert any(message in fault for fault in error.value.faults), error.value.faults


def test_damage_is_told_before_the_filter_smears_it() -> None:
    """A lost reading is taken out, a faulty trial and one that is cut off are left out, a peak alone as well."""
    dataset = made_up(0)
    trials = list(dataset.trials)
    force = trials[3].trace.force.copy()  # type: ignore[union-attr]
    force[40] = -9999.0
    dataset = with_trial(dataset, 3, with_force(trials[3], force))
    hole = trials[8].trace.force.copy()  # type: ignore[union-attr]
    hole[50:60] = 0.0
    dataset = with_trial(dataset, 8, with_force(trials[8], hole))
    dataset = with_trial(dataset, 5, replace(trials[5], trace=None))
    dataset = replace(dataset, measurement=replace(dataset.measurement, range_n=309.0))
    cut = with_force(trials[19], np.minimum(trials[19].trace.force, 309.0))  # type: ignore[union-attr]
    dataset = with_trial(dataset, 19, cut)
    far = trials[1].trace
    assert far is not None
    late = Trace(np.append(far.time, 1e3), np.append(far.force, 0.0))
    dataset = with_trial(dataset, 1, replace(trials[1], trace=late))
    quality = assess_low_passed(dataset, LowPass(400.0, 4))
    reasons = {name: quality.excluded[name] for name in ("t001", "t005", "t008", "t019")}
    assert "uneven" in reasons["t001"]
    assert "no trace" in reasons["t005"] and "drops out" in reasons["t008"] and "smear" in reasons["t019"]
    assert "t003" not in quality.excluded and "1 lost reading is taken out" in quality.doubts[0]
    assert quality.dataset.measurement.low_pass == LowPass(400.0, 4)
    gain = Filter(LowPass(400.0, 4), 1 / RATE).gain
    assert quality.noise.std == pytest.approx(gain, rel=1e-3)  # 1 N is stated
    assert quality.noise.source == "stated"
    whole = next(t for t in quality.dataset.trials if t.name == "t003")
    assert np.abs(whole.trace.force).max() < 400  # type: ignore[union-attr]


def test_what_cannot_be_filtered_is_refused() -> None:
    dataset = made_up(0)
    again = replace(dataset, measurement=replace(dataset.measurement, low_pass=LowPass(400.0)))
    peaks = replace(dataset, trials=tuple(replace(t, trace=None) for t in dataset.trials))
    for one, cutoff, message in (
        (again, 300.0, "states measurement.low_pass"),
        (dataset, 9000.0, "give less than half"),
        (dataset, float("nan"), "must be a finite number"),
        (peaks, 400.0, "0 of 20 trials have a whole trace"),
    ):
        with pytest.raises(InputError, match=message):
            assess_low_passed(one, LowPass(cutoff, 4))


def test_coloured_noise_passes_as_far_as_it_is_slow() -> None:
    dataset = made_up(1, stated=False, share=0.5, tau=5e-3)
    whole = assess_dataset(dataset).noise
    quality = assess_low_passed(dataset, LowPass(400.0, 4))
    assert isinstance(quality.noise, Noise) and 0.4 * whole.std < quality.noise.std < whole.std

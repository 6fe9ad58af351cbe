"""The line that says whether data can be trusted: what limits them, each with its remedy."""

from dataclasses import replace

import numpy as np
import pytest
from impacts import CONDITIONS, made_up, with_force

from acf_jax.dataset import assess_dataset


def trust(dataset):
    return assess_dataset(dataset).trust()


def clipped(dataset, at):
    return replace(
        dataset, trials=tuple(with_force(t, np.minimum(t.trace.force, at)) for t in dataset.trials)
    )


def shifted(dataset, by):
    return replace(dataset, trials=tuple(with_force(t, t.trace.force + by) for t in dataset.trials))


def stating(dataset, noise):
    return replace(dataset, measurement=replace(dataset.measurement, force_noise_std_n=noise))


def peaks_of(dataset):
    return replace(dataset, trials=tuple(replace(t, trace=None) for t in dataset.trials))


def test_sound_data_are_told_to_be_so():
    found = trust(made_up(0))
    assert found.headline == (
        "Data: nothing speaks against them; 20 trials at 10 conditions, 5 speeds, 2 pretensions, sampled at 8 kHz."
    )
    assert found.lines == ()


LIMITS = {
    "sampling rate": (made_up(0, rate=600.0), "600 Hz", "Hz or faster"),
    "saturation": (clipped(made_up(0), 200.0), "cut off at 200 N", "a sensor of a larger range"),
    "offset": (shifted(made_up(0), 25.0), "reads +24.9", "zero it"),
    "one speed": (made_up(0, conditions=[(0.2, p) for p in (40.0, 60.0, 80.0, 100.0)]), "at 0.2 m/s", "add trials"),
    "one pretension": (made_up(0, conditions=CONDITIONS[:5]), "pretension of 60 N", "add trials"),
    "few trials": (made_up(0, conditions=[(v, p) for v in (0.1, 0.3) for p in (60.0,)] + [(0.1, 100.0)]),
                   "6 trials at 3 conditions", "ten conditions"),
    "no repeats": (made_up(0, repeats=1), "no condition is repeated", "repeat each"),
    "no traces": (peaks_of(made_up(0)), "peaks without traces", "record the force over time"),
    "stated noise": (stating(made_up(0), 3.0), "stated as 3 N", "correct it"),
}  # fmt: skip


@pytest.mark.parametrize("word", LIMITS)
def test_each_limit_leads_with_its_remedy(word):
    dataset, fact, remedy = LIMITS[word]
    found = trust(dataset)
    assert [limit.word for limit in found.limits] == [word]
    assert found.headline.startswith(f"Data: limited by {word}; ")
    (line,) = found.lines
    assert fact in line and remedy in line
    assert line in assess_dataset(dataset).warnings


def test_the_advised_rate_is_fast_enough():
    """Sampled as advised the peak is missed by no more than is passed over without a word."""
    slow = made_up(0, rate=600.0)
    line = trust(slow).lines[0]
    rate = float(line.partition("sample at ")[2].split(" Hz")[0].replace(",", ""))
    assert 600.0 < rate < 8000.0
    assert not [limit for limit in trust(made_up(0, rate=rate)).limits if limit.word == "sampling rate"]


def test_speeds_within_their_scatter_are_one():
    speeds = (0.2, 0.201, 0.199)
    found = trust(made_up(0, conditions=[(v, p) for p in (40.0, 60.0, 80.0, 100.0) for v in speeds]))
    assert "one speed" in [limit.word for limit in found.limits]
    apart = trust(made_up(0, conditions=[(v, p) for p in (60.0, 100.0) for v in (0.2, 0.25)]))
    assert apart.limits == ()


def test_trials_that_a_fit_leaves_out_count():
    quality = assess_dataset(made_up(0))
    gone = {t.name: "late" for t in quality.trials[2:]}
    found = quality.trust(gone)
    assert found.headline.startswith(
        "Data: limited by trials left out, one speed, one pretension, few trials; 2 trials"
    )
    assert found.lines[0].startswith("18 of 20 trials are left out (t002: late; ")

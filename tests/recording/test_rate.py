"""Forces sampled too slowly for their impacts: told with numbers, and with the rate that would do."""

from pathlib import Path

import numpy as np
import pytest

from acf_jax.dataset.trials import Prior, RigPrior
from acf_jax.recording import Impacts, Refused, Session, find_impacts
from acf_jax.recording.mapping import Contacts
from acf_jax.recording.rate import advised_rate, missed_share, too_slow
from acf_jax.recording.series import Series

LABELS = {"force": "f", "speed": "v", "pretension": "p"}
LASTS, HEIGHT = 0.013, 200.0  # s and N, of the half-sines
RIG = RigPrior(Prior(2.0, 0.3), Prior(60.0, 40.0), Prior(1500.0, 1500.0), Prior(1.2e5, 6e4))


@pytest.mark.parametrize("step", [1e-4, 1e-3, 4e-3, 8e-3, 0.012])
def test_the_share_is_that_of_the_worst_phase(step):
    """Of all phases of sampling a half-sine the one that reads least."""
    phases = np.linspace(0.0, step, 2001)[:, None]
    time = phases + step * np.arange(-1, int(LASTS / step) + 2)
    sampled = np.where((time >= 0.0) & (time <= LASTS), np.sin(np.pi * time / LASTS), 0.0)
    assert missed_share(step, LASTS) == pytest.approx(1.0 - sampled.max(1).min(), abs=1e-3)
    assert missed_share(2.0 * LASTS, LASTS) == pytest.approx(1.0)


def test_the_advised_rate_misses_a_thousandth():
    assert [advised_rate(t) for t in (0.013, 0.03, 0.1, 0.002, 0.9)] == [
        "4 kHz", "2 kHz", "400 Hz", "20 kHz", "40 Hz",
    ]  # fmt: skip
    assert too_slow(2e-4, 0.013) is None
    assert "every 10 ms, and an impact lasts about 13 ms: peaks are up to 65 % too low" in str(
        too_slow(0.01, 0.013)
    )


def recorded(rate: float, noise: float = 0.4) -> Impacts:
    """Eight impacts that ring about the force that presses on, at `rate` Hz; the robot at its pace before."""
    rng = np.random.default_rng(0)
    time = np.arange(0.0, 5.2, 1.0 / rate)
    force, speed = np.zeros((2, time.size))
    for i in range(8):
        since = time - 0.5 - 0.55 * i - rng.uniform(0.0, 0.02)
        rings = 1.0 - np.cos(np.pi * since / LASTS) * np.exp(-15.0 * np.maximum(since, 0.0))
        force += 0.5 * HEIGHT * rings * ((since >= 0.0) & (since < 0.1))
        speed += 0.2 * ((since > -0.2) & (since < 0.01)) - 0.2 * ((since > 0.1) & (since < 0.2))
    times = np.rint(1e9 * time).astype(np.int64)
    force, speed = force + rng.normal(0.0, noise, time.size), speed + rng.normal(0.0, 5e-4, time.size)
    session = Session(Path("x"), Series(times, force), Series(times, speed), False, 60.0, LABELS, ())
    return find_impacts(session, Contacts(), RIG)


@pytest.mark.parametrize("rate", [100, 125, 250, 500])
def test_a_slow_log_says_by_how_much_its_peaks_are_wrong(rate):
    """At least what the worst phase misses of this force, half of which rings; at most that of a half-sine."""
    impacts = recorded(rate)
    (note,) = (note for note in impacts.notes if "too low" in note)
    assert f"a sample every {1e3 / rate:g} ms" in note and "; record it faster, at " in note
    share = float(note.split("up to ")[1].split(" %")[0])
    worst = 100.0 * missed_share(1.0 / rate, LASTS)
    assert 0.45 * worst < share < 1.1 * worst
    peak = 0.5 * HEIGHT * (1.0 + np.exp(-15.0 * LASTS))
    assert min(cut.peak for cut in impacts.kept) > peak * (1.0 - 0.01 * share) - 2.0


@pytest.mark.parametrize("rate", [1000, 4000])
def test_a_fast_log_says_nothing(rate):
    assert not any("too low" in note for note in recorded(rate).notes)
    assert len(recorded(rate).kept) == 8


def test_contacts_of_few_samples_are_no_spikes():
    """At 125 Hz an impact of 13 ms that is lost again is one or two samples: faster, not another column."""
    time = np.arange(0.0, 4.0, 0.008)
    force = np.random.default_rng(0).normal(0.0, 0.4, time.size)
    force[50::60] += 150.0
    times = np.rint(1e9 * time).astype(np.int64)
    session = Session(Path("x"), Series(times, force), 0.2, False, 60.0, {"force": "f"}, ())
    with pytest.raises(Refused) as caught:
        find_impacts(session, Contacts(), RIG)
    assert "but never for 3 samples, as in contact; record the force faster" in caught.value.faults[0]
    assert "peaks are up to 45 % too low; record it faster, at 4 kHz" in caught.value.faults[1]


@pytest.mark.parametrize("rate", [40, 50, 60])
def test_a_log_that_cannot_tell_the_approach(rate):
    with pytest.raises(Refused, match=r"where 16 are needed; the force has .* record it faster, at 4 kHz"):
        recorded(rate)


def test_noise_is_no_reason_to_record_more():
    """Contacts that are doubtful at a slow rate ask for a faster one."""
    time = np.arange(0.0, 4.0, 0.01)
    force = np.random.default_rng(0).normal(0.0, 1.0, time.size)
    for first in range(50, 390, 30):  # the second half of each pause holds 14 samples
        force[first : first + 3] += 80.0
    times = np.rint(1e9 * time).astype(np.int64)
    session = Session(Path("x"), Series(times, force), 0.2, False, 60.0, {"force": "f"}, ())
    with pytest.raises(Refused, match=r"of 12 contacts can be used.*record it faster, at ") as caught:
        find_impacts(session, Contacts(), RIG)
    cuts = caught.value.impacts.cuts
    assert len(cuts) == 12 and all(
        "record the force faster" in cut.remarks[0] for cut in cuts if not cut.keep
    )

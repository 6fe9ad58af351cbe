"""Speeds without noise, speeds that a faster log holds, and robots that are sampled slowly."""

import numpy as np
import pytest

from acf_jax.recording.series import Series
from acf_jax.recording.velocity import Character, character_of, velocity_at

SPEEDS = (0.1, 0.2, 0.3) * 4
APART = 0.5  # s
CONTACTS = APART * (1.0 + np.arange(len(SPEEDS)))


def commanded(
    time: np.ndarray, approach: float, ramp: float = 0.0, back: float = 0.0, sign: float = 1.0
) -> np.ndarray:
    """At rest, for `approach` s before and 20 ms after contact at its speed, which a ramp leads to; then back."""
    speed = np.zeros(time.size)
    for contact, v in zip(CONTACTS, SPEEDS, strict=True):
        since = time - contact
        grown = np.clip((since + approach + ramp) / ramp, 0.0, 1.0) if ramp else since > -approach
        speed += v * grown * (since < 0.02) * (since > -approach - ramp)
        speed -= back * ((since > 0.05) & (since < 0.1))
    return sign * np.round(speed, 6)


def found(rate: float, value: np.ndarray):
    """What is measured at each contact, some samples' fraction after one."""
    times = np.rint(1e9 * np.arange(value.size) / rate).astype(np.int64)
    series = Series(times, value)
    character = character_of(series, False)
    return [
        velocity_at(series, False, round(1e9 * (contact + 0.4 / rate)), character) for contact in CONTACTS
    ]


def sampled(rate: float, **shape: float) -> np.ndarray:
    return commanded(np.arange(0.0, APART * (len(SPEEDS) + 1), 1.0 / rate), **shape)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("rate", [8000.0, 1000.0, 125.0, 50.0])
@pytest.mark.parametrize(
    "shape",
    [
        {"approach": 0.1},
        {"approach": 0.07},
        {"approach": 0.1, "back": 0.05},
        {"approach": 0.08, "ramp": 0.1},
        {"approach": 0.3, "ramp": 0.03},
    ],
)
def test_a_commanded_speed_is_exact(rate, shape, sign):
    """A clean step, or a ramp and then a step, whatever samples it."""
    for estimate, v in zip(found(rate, sampled(rate, sign=sign, **shape)), SPEEDS, strict=True):
        assert estimate.value == pytest.approx(sign * v, abs=1e-9)
        assert estimate.std == pytest.approx(0.001 * v)


@pytest.mark.parametrize("robot", [500.0, 125.0, 50.0])
def test_a_commanded_speed_that_is_held(robot):
    """By a log of 8 kHz, between the robot's updates: the ramp is steps then."""
    value = np.repeat(sampled(robot, approach=0.1, ramp=0.1), round(8000.0 / robot))
    for estimate, v in zip(found(8000.0, value), SPEEDS, strict=True):
        assert estimate.value == pytest.approx(v, abs=1e-9) and estimate.std <= 0.0011 * v


@pytest.mark.parametrize("robot", [125.0, 50.0, 10.0])
def test_noise_that_is_held_counts_once(robot):
    """A robot with noise, held at 8 kHz, is no more certain than by its own samples."""
    rng = np.random.default_rng(0)
    own = sampled(robot, approach=0.3)
    own += rng.normal(0.0, 2e-3, own.size)
    off = []
    for estimate, v in zip(found(8000.0, np.repeat(own, round(8000.0 / robot))), SPEEDS, strict=True):
        assert estimate.std > 2e-3 / (0.3 * robot + 1.0) ** 0.5 / 2.0
        off.append((estimate.value - v) / estimate.std)
    assert np.mean(np.abs(off) < 3.0) > 0.8


@pytest.mark.parametrize("rate", [8000.0, 1000.0, 125.0, 62.5])
def test_a_noisy_step_keeps_its_word(rate):
    """A step 0.12 s before contact: nearly all within three standard deviations, which are a few per cent at most."""
    off, stds = [], []
    for seed in range(20):
        value = sampled(rate, approach=0.12)
        value = value + np.random.default_rng(seed).normal(0.0, 1e-3, value.size)
        for estimate, v in zip(found(rate, value), SPEEDS, strict=True):
            off.append((estimate.value - v) / estimate.std)
            stds.append(estimate.std / v)
    assert np.mean(np.abs(off) < 1.0) > 0.55 and np.mean(np.abs(off) < 3.0) > 0.97
    assert np.quantile(stds, 0.95) < 0.02


def test_character():
    """Noise is told as it is, of speeds and of positions; a clean signal has none."""
    rng = np.random.default_rng(0)
    time = np.arange(0.0, 5.0, 0.008)
    times = np.rint(1e9 * time).astype(np.int64)
    noisy = commanded(time, approach=0.3) + rng.normal(0.0, 1e-3, time.size)
    assert character_of(Series(times, noisy), False).noise_std == pytest.approx(1e-3, rel=0.3)
    place = 0.1 * time + rng.normal(0.0, 3e-5, time.size)
    character = character_of(Series(times, place), True)
    assert character.noise_std == pytest.approx(3e-5, rel=0.2) and character.steady == np.inf
    assert character_of(Series(times[:0], noisy[:0]), False) == Character(steady=0.0)
    assert character_of(Series(times, np.full(time.size, 0.1)), True) == Character()

"""Contacts, velocities and cuts against recordings whose truth is known."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sessions import APART, Made, made

from acf_jax.errors import InputError
from acf_jax.recording import Refused, Session, find_impacts
from acf_jax.recording.contacts import find_contacts
from acf_jax.recording.cut import group, spread
from acf_jax.recording.mapping import Contacts
from acf_jax.recording.page import import_page
from acf_jax.recording.series import Series
from acf_jax.recording.velocity import Estimate, velocity_at

SAMPLE = 125_000  # ns


def series(session: Made, scale: float = 1.0) -> Series:
    return Series(session.time, scale * session.force)


@pytest.mark.parametrize(
    "change",
    [{}, {"std": 0.2}, {"offset": -15.0}, {"drift": 1.0}, {"bounce": False}, {"std": 4.0}, {"rate": 1000.0}],
    ids=str,
)
def test_contacts_are_found_within_a_sample(change):
    """Each contact once, at its first impact, whatever noise, offset or drift the sensor has."""
    for seed in range(2):
        session = made(seed, **change)
        _, found = find_contacts(series(session), Contacts(), "force")
        # at 1 kHz a whole impact is a dozen samples, and its onset may be put a sample early
        early = np.array(session.first) - [contact.first for contact in found]
        assert set(early) <= ({0} if "rate" not in change else {0, 1})
        late = np.array([c.begin for c in found]) - session.contacts
        assert np.abs(late).max() < 1e9 / change.get("rate", 8000.0)
        expected = change.get("offset", 0.0) + change.get("drift", 0.0) * 1e-9 * np.array(session.contacts)
        assert np.abs([c.offset for c in found] - expected).max() < max(1.0, change.get("std", 0.0))


def test_onset_of_a_force_that_climbs_from_zero():
    """A flange on its stop: no jump; the line through the first samples leads back to contact."""
    rng = np.random.default_rng(3)
    time = np.rint(np.arange(0.0, 3.0, 1 / 8000.0) * 1e9).astype(np.int64)
    begins = np.rint(1e9 * (np.arange(0.5, 2.7, 0.3) + rng.uniform(0.0, 0.01, 8))).astype(np.int64)
    force = rng.normal(0.0, 0.3, time.size)
    for begin in begins:
        since = 1e-9 * (time - begin)
        force += np.where((since > 0.0) & (since < 0.01), 3.0e4 * since - 1.5e6 * since**2, 0.0)
    _, found = find_contacts(Series(time, force), Contacts(), "force")
    late = np.array([contact.begin for contact in found]) - begins
    assert len(found) == 8 and np.abs(late).max() < 2 * SAMPLE and np.abs(late.mean()) < SAMPLE


@pytest.mark.parametrize("rate, std", [(50e3, 1.0), (100e3, 0.1), (100e3, 1.0)])
def test_onset_of_a_slow_climb_sampled_fast(rate, std):
    """A half-sine hump: hundreds of samples lie between first contact and a force that is clear."""
    rng = np.random.default_rng(5)
    time = np.arange(0.0, 1.6, 1 / rate)
    begins = [0.4, 0.8, 1.2]
    force = rng.normal(0.0, std, time.size)
    omega = np.sqrt(1.5e5 / 4.8)
    for begin, v in zip(begins, (0.05, 0.1, 0.2), strict=True):
        force += (
            1.5e5 * v / omega * np.clip(np.sin(omega * np.clip(time - begin, 0.0, np.pi / omega)), 0.0, None)
        )
    _, found = find_contacts(Series(np.rint(1e9 * time).astype(np.int64), force), Contacts(), "force")
    late = [1e-9 * contact.begin - begin for contact, begin in zip(found, begins, strict=True)]
    assert np.abs(late).max() < 2.5e-4, late


def test_spikes_and_chatter_are_no_contacts():
    session = made()
    force = session.force.copy()
    between = [round((0.3 + APART * i - 0.1) * 8000) for i in range(4)]
    force[between] = 400.0
    force[[i + 400 for i in between[:2]]] = -300.0
    _, found = find_contacts(Series(session.time, force), Contacts(), "force")
    assert [contact.first for contact in found] == session.first


def test_a_negative_force_is_named():
    with pytest.raises(InputError, match=r"negative in contact .*; put -1\* before its name"):
        find_contacts(series(made(), -1.0), Contacts(), "force")


def test_no_contact_is_named():
    session = made()
    quiet = Series(session.time, np.random.default_rng(0).normal(0.0, 1.0, session.time.size))
    with pytest.raises(InputError, match="shows no contact"):
        find_contacts(quiet, Contacts(), "force")


@pytest.mark.parametrize("is_position", [False, True])
def test_velocity_keeps_its_word(is_position):
    """Of many contacts two thirds lie within one standard deviation, nearly all within three; none is far too wide."""
    normal = []
    for seed in range(12):
        session = made(seed)
        robot = Series(session.beats, session.position if is_position else session.velocity)
        for begin, (v, _) in zip(session.contacts, session.impacts, strict=True):
            measured = velocity_at(robot, is_position, begin)
            normal.append((measured.value - v) / measured.std)
            assert measured.std < 0.02 * max(v, 0.1)
    normal = np.abs(normal)
    assert 0.5 < np.mean(normal < 1.0) < 0.95 and np.mean(normal < 3.0) > 0.985 and normal.max() < 6.0


def test_velocity_where_the_robot_still_accelerates():
    time = np.rint(1e9 * np.arange(0.0, 1.0, 0.004)).astype(np.int64)
    ramp = np.clip(2.0 * (1e-9 * time - 0.85), 0.0, None)  # 2 m/s^2
    noise = np.random.default_rng(1).normal(0.0, 1e-3, time.size)
    measured = velocity_at(Series(time, ramp + noise), False, 1_000_000_000)
    assert measured.value == pytest.approx(0.3, abs=4 * measured.std) and measured.std < 2e-3


def test_velocity_of_held_values():
    """A robot of 125 Hz in a log of 8 kHz knows as little as one in a log of 125 Hz."""
    session = made(5)
    held = np.maximum(np.searchsorted(session.beats, session.time, "right") - 1, 0)
    for begin, (v, _) in zip(session.contacts, session.impacts, strict=True):
        own = velocity_at(Series(session.beats, session.velocity), False, begin)
        repeated = velocity_at(Series(session.time, session.velocity[held]), False, begin)
        assert repeated.value == pytest.approx(v, abs=4 * repeated.std)
        assert 0.3 < repeated.std / own.std < 3.0


@pytest.mark.parametrize("rate", [125.0, 1000.0])
@pytest.mark.parametrize("steady", [0.0, 0.1, 0.3])
def test_velocity_that_is_commanded(rate, steady):
    """A ramp from rest to 0.1 m/s in 0.1 s, steady for a while: equal values are not all repeats of a held one."""
    time = np.arange(-1.0, 0.0, 1 / rate)
    value = np.clip(0.1 + (time + steady) * 1.0, 0.0, 0.1)
    found = velocity_at(Series(np.rint(1e9 * time).astype(np.int64), value), False, 0)
    assert found.value == pytest.approx(0.1, abs=max(3 * found.std, 2e-4))
    assert found.std < 5e-3


def test_velocity_that_never_changes_is_known_well():
    series = Series(np.arange(-1_000_000_000, 0, 8_000_000), np.full(125, 0.1))
    assert velocity_at(series, False, 0).std == pytest.approx(1e-4)


def test_velocity_in_coarse_steps():
    """Read to 1 mm/s with 0.2 mm/s of noise: most neighbours are equal, and all of them count."""
    rng = np.random.default_rng(3)
    time = np.arange(-1_000_000_000, 0, 8_000_000)
    found = []
    for _ in range(40):
        value = np.round(0.1234 + rng.normal(0.0, 2e-4, time.size), 3)
        found.append(velocity_at(Series(time, value), False, 0).value)
    assert np.mean(found) == pytest.approx(0.1234, abs=5e-4)


def test_scatter_is_that_of_the_impacts():
    """Not how uncertain each is, nor that of a pretension next to nothing."""
    rng = np.random.default_rng(2)
    groups = np.repeat([0.05, 0.2, 0.35], 30)
    true = groups * (1 + 0.004 * rng.normal(size=groups.size))
    measured = [Estimate(v + 1e-3 * rng.normal(), 1e-3) for v in true]
    assert spread(measured, groups) == pytest.approx(0.004, rel=0.5)
    pretensions = [Estimate(v, 0.03) for v in (0.3, 0.1, 0.4, 0.2, 60.1, 59.9, 60.2, 59.8)]
    found = spread(pretensions, np.repeat([0.25, 60.0], 4))
    assert found == pytest.approx(0.003, abs=1e-3)


def test_a_pretension_of_nothing_may_read_a_little_below(tmp_path):
    few = made(0, tuple((v, p) for p in (0.0, 60.0) for v in (0.1, 0.2, 0.3) for _ in range(2)))
    read = few.pretension + np.random.default_rng(1).normal(0.0, 0.3, few.beats.size) - 0.1
    robot, preload = Series(few.beats, few.velocity), Series(few.beats, read)
    session = Session(tmp_path, series(few), robot, False, preload, {"force": "f"}, ())
    found = find_impacts(session, Contacts(), None)
    conditions = {cut.condition[1] for cut in found.kept}
    assert min(cut.pretension.value for cut in found.kept) < 0.0 and min(conditions) == 0.0
    assert found.pretension_spread is None or found.pretension_spread < 0.01


@pytest.mark.parametrize("after", [5e-4, 1e-3])
def test_a_recording_that_ends_within_an_impact(tmp_path, after):
    few = made(0)
    end = int(np.searchsorted(few.time, few.contacts[-1] + round(1e9 * after)))
    robot, preload = Series(few.beats, few.velocity), Series(few.beats, few.pretension)
    force = Series(few.time[:end], few.force[:end])
    session = Session(tmp_path, force, robot, False, preload, {"force": "f"}, ())
    cut = find_impacts(session, Contacts(), None).cuts[-1]
    assert not cut.keep and "while the force rises" in cut.remarks[-1]


def test_conditions_are_those_of_their_repeats():
    values = [Estimate(v, 2e-4) for v in (0.0501, 0.2003, 0.0498, 0.1995, 0.35, 0.0500)]
    assert group(values).tolist() == [0.04997, 0.1999, 0.04997, 0.1999, 0.35, 0.04997]
    chain = [Estimate(v, 0.01) for v in np.arange(0.05, 0.2, 0.01)]
    assert np.unique(group(chain)).size > 2  # each agrees with the next, the first not with the last


SHAPES = {
    "constant": lambda rng, n: np.full(n, rng.choice([0.0, 1e-9, 100.0, -50.0])),
    "noise": lambda rng, n: rng.normal(0.0, 10.0 ** rng.uniform(-6, 3), n),
    "steps": lambda rng, n: np.repeat(rng.integers(-1, 4, n // 50 + 1) * 60.0, 50)[:n],
    "pulses": lambda rng, n: (
        200.0 * (np.sin(np.arange(n) * rng.uniform(1e-3, 0.5)) > 0.9) + rng.normal(0.0, 1.0, n)
    ),
    "huge": lambda rng, n: rng.normal(0.0, 1e11, n),
}


@settings(max_examples=80, deadline=None, derandomize=True, database=None)
@given(
    seed=st.integers(0, 10**6),
    force=st.sampled_from([*SHAPES]),
    speed=st.sampled_from([*SHAPES]),
    is_position=st.booleans(),
    is_apart=st.booleans(),
)
def test_any_signals_end_in_cuts_or_in_faults(seed, force, speed, is_position, is_apart):
    rng = np.random.default_rng(seed)
    sizes = rng.choice([1, 2, 30, 500, 5000], 2)
    steps = [rng.choice([1, 10**5, 10**6, 10**9]) * rng.integers(1, 3, size) for size in sizes]
    times = [np.cumsum(step).astype(np.int64) for step in steps]
    with np.errstate(over="ignore"):
        values = [SHAPES[name](rng, size) for name, size in zip((force, speed), sizes, strict=True)]
    signals = [Series(time, value) for time, value in zip(times, values, strict=True)]
    labels = {"force": "f", "speed": "v"}
    session = Session(Path("any"), signals[0], signals[1], is_position, 60.0, labels, ())
    if is_apart:
        session = replace(session, elsewhere={"speed": 1}, apart=frozenset({"speed"}))
    try:
        impacts = find_impacts(session, Contacts(), None)
    except Refused as error:
        assert error.faults and "Why no data set came of it" in import_page(error.impacts, None, "set")
    else:
        assert len(impacts.kept) >= 3 and all(np.isfinite(cut.velocity.value) for cut in impacts.kept)

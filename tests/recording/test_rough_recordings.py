"""Recordings as rigs make them: sensors never tared, clocks that are not one, samples that are missing."""

from pathlib import Path

import numpy as np
import pytest
from sessions import APART, BEGIN, FEW, Made, made

from acf_jax.errors import InputError
from acf_jax.recording import Impacts, Session, find_impacts
from acf_jax.recording.clock import settle, to_clock_of
from acf_jax.recording.contacts import find_contacts
from acf_jax.recording.mapping import Contacts
from acf_jax.recording.series import Series
from tests.dataset.impacts import RIG, contact_force

RATE = 2000.0
HALF = 0.3 + 4 * APART - 0.15  # s, between the fourth and the fifth contact
LABELS = {"force": "f", "speed": "v", "pretension": "p"}


def session() -> Made:
    return made(3, FEW, rate=RATE)


def impacts_of(force: Series, velocity: Series) -> Impacts:
    pretension = Series(session().beats + int(force.time[0] // BEGIN * BEGIN), session().pretension)
    return find_impacts(Session(Path("x"), force, velocity, False, pretension, LABELS, ()), Contacts(), RIG)


def with_force(change) -> Impacts:
    truth = session()
    force = change(truth.force.copy(), truth.seconds)
    return impacts_of(Series(truth.time, force), Series(truth.beats, truth.velocity))


def check(found: Impacts, but=(), begin: int = 0):
    """Those kept are the true ones, `but` some: contact within a sample, velocity, condition, pretension."""
    truth = session()
    rest = [i for i in range(len(FEW)) if i not in but]
    kept = found.kept
    assert len(kept) == len(rest)
    late = np.array([cut.contact.begin - begin for cut in kept]) - np.array(truth.contacts)[rest]
    assert np.abs(late).max() < 1e9 / RATE
    for cut, i in zip(kept, rest, strict=True):
        v, f_p = truth.impacts[i]
        assert abs(cut.velocity.value - v) < max(4.0 * cut.velocity.std, 0.01 * v)
        assert cut.condition[0] == pytest.approx(v, rel=0.02) and cut.condition[1] == f_p


def pulse(newtons: float, early: float):
    """The inertia of a tool for 10 ms, `early` s before each contact."""
    begins = 1e-9 * np.array(session().contacts)[:, None] - early
    return lambda f, t: f + newtons * ((t > begins) & (t < begins + 0.01)).any(0)


READS, STEP = "N before contact: taken off", "a step of the sensor"
SMALL, SLOW, BEHIND = "is far below the pretension", "m/s is uncertain by", "begun after a pulse too small"
# what the sensor does, what is said about it, and how many contacts that are none are listed, not kept
FORCES = {
    "bias -120 N": (lambda f, t: f - 120.0, READS, 0),
    "bias -90 N": (lambda f, t: f - 90.0, READS, 0),
    "bias -60 N": (lambda f, t: f - 60.0, READS, 0),
    "bias +50 N": (lambda f, t: f + 50.0, READS, 0),
    "bias +90 N": (lambda f, t: f + 90.0, READS, 0),
    "drift +5 N/s": (lambda f, t: f + 5.0 * t, READS, 0),
    "drift -20 N/s": (lambda f, t: f - 20.0 * t, READS, 0),
    "10 N to and fro in 1 s": (lambda f, t: f + 10.0 * np.sin(2.0 * np.pi * t), READS, 0),
    "turned by -25 N": (lambda f, t: f - 25.0 * (t > HALF), READS, 0),
    "turned by +25 N": (lambda f, t: f + 25.0 * (t > HALF), STEP, 1),
    "turned by +50 N and back": (lambda f, t: f + 50.0 * ((t > HALF) & (t < HALF + 2 * APART)), STEP, 1),
    "turned slowly": (lambda f, t: f + 25.0 * np.clip((t - HALF + 0.13) / 0.2, 0.0, 1.0), STEP, 1),
    "spindle": (lambda f, t: f + 6.0 * np.sin(2.0 * np.pi * 83.0 * t), "", 0),
    "begins in contact": (lambda f, t: f + 50.0 * (t < 0.2), "", 0),
    "pulse of 12 N, 55 ms before": (pulse(12.0, 0.055), BEHIND, 0),
    "pulse of 30 N, 30 ms before": (pulse(30.0, 0.030), BEHIND, 0),
    "pulse of 12 N, 140 ms before": (pulse(12.0, 0.140), SMALL, 8),
    "pulse of 30 N, 140 ms before": (pulse(30.0, 0.140), SLOW, 8),
}


@pytest.mark.parametrize("name", FORCES)
def test_the_free_force_may_move(name):
    change, said, dropped = FORCES[name]
    found = with_force(change)
    check(found)
    assert len(found.cuts) == len(FEW) + dropped
    remarks = [remark for cut in found.cuts for remark in cut.remarks]
    assert said in "; ".join([*found.notes, *remarks]) and (said or not found.notes)


@pytest.mark.parametrize("bias", [-120.0, 0.0, 50.0, 90.0])
def test_a_negative_force_is_named_at_any_bias(bias):
    with pytest.raises(InputError, match=r"negative in contact .*; put -1\* before its name"):
        with_force(lambda f, t: bias - f)


def test_long_contacts_on_a_drifting_sensor():
    """Pressed for two seconds, while the force swings, is lost for 50 ms and drifts further than the threshold."""
    time = np.arange(0.0, 20.0, 1e-3)
    begins = np.arange(1.0, 18.0, 4.0)
    force = np.random.default_rng(0).normal(0.0, 1.0, time.size) + 6.0 * time
    for begin in begins:
        since = time - begin
        pressed = 60.0 + 15.0 * np.sin(30.0 * since)
        force += contact_force(since, 0.2, 60.0) * (since < 0.02)
        force += pressed * ((since > 0.04) & (since < 2.0) & ~((since > 1.0) & (since < 1.05)))
    _, found = find_contacts(Series(np.rint(1e9 * time).astype(np.int64), force), Contacts(), "force")
    assert np.abs(np.array([1e-9 * contact.begin for contact in found]) - begins).max() < 1e-3
    assert np.abs(np.array([contact.offset for contact in found]) - 6.0 * begins).max() < 1.5


def recorded(time: np.ndarray, value: np.ndarray, ahead) -> Series:
    """A topic whose stamps run `ahead` s, 100 to 120 us on its way to the recorder."""
    delay = np.random.default_rng(time.size).integers(100_000, 120_000, time.size)
    stamps = BEGIN + time + np.rint(1e9 * ahead(1e-9 * time)).astype(np.int64)
    return Series(stamps, value, BEGIN + time + delay)


def on_one_clock(force_ahead, robot_ahead) -> Impacts:
    truth = session()
    force = settle(recorded(truth.time, truth.force, force_ahead), "f")
    robot = settle(recorded(truth.beats, truth.velocity, robot_ahead), "v")
    robot = to_clock_of(robot, force, "v")
    found = impacts_of(force, robot)
    assert [note for note in (*force.notes, *robot.notes) if "the clock" in note or "its clock" in note]
    return found


CLOCKS = {
    **{
        f"{shift:g} s": (lambda t, shift=shift: shift + 0.0 * t) for shift in (-0.09, -0.05, 0.05, 0.09, 37.0)
    },
    "drift": lambda t: 5e-3 * t,
    "shift and drift": lambda t: 0.06 + 2e-3 * t,
    **{f"step of {step:g} s": (lambda t, step=step: step * (t > HALF)) for step in (0.03, 0.5, -0.5, 2.0)},
    "late step": lambda t: -0.5 * (t > 3.0),
}


@pytest.mark.parametrize("name", CLOCKS)
def test_clocks_are_brought_to_one(name):
    check(on_one_clock(np.zeros_like, CLOCKS[name]), begin=BEGIN)


@pytest.mark.parametrize("step", [0.5, -0.5])
def test_the_clock_of_the_force_may_be_set(step):
    found = on_one_clock(lambda t: step * (t > HALF), lambda t: 37.0 + 0.0 * t)
    check(found, begin=BEGIN)


def test_one_clock_stays_as_it_is():
    """Delays of milliseconds that scatter, and a recorder that stood still for a while, are no clock."""
    truth = session()
    rng = np.random.default_rng(0)
    delay = np.rint(2e5 + 3e6 * rng.exponential(size=truth.beats.size)).astype(np.int64)
    stall = (truth.beats > 1_500_000_000) & (truth.beats < 1_900_000_000)
    received = np.where(stall, 1_900_000_000, truth.beats) + delay
    robot = Series(truth.beats + BEGIN, truth.velocity, received + BEGIN)
    force = recorded(truth.time, truth.force, np.zeros_like)
    assert to_clock_of(settle(robot, "v"), force, "v") is robot


@pytest.mark.parametrize(
    "early, late, missing",
    [(0.003, 0.004, 7.5), (0.06, -0.002, 58.5), (-0.003, 0.03, 27.5), (0.2, 0.2, 401.0)],
    ids=["over the onset", "before contact", "after contact", "the whole contact"],
)
def test_missing_samples_are_named(early, late, missing):
    truth, contact = session(), 1e-9 * session().contacts[2]
    there = (truth.seconds < contact - early) | (truth.seconds >= contact + late)
    found = impacts_of(Series(truth.time[there], truth.force[there]), Series(truth.beats, truth.velocity))
    check(found, but=(2,))
    assert [c.remarks[0][:19] for c in found.cuts if not c.keep] == ["samples are missing"] * (
        missing < 401.0
    )
    assert f"missing once, for {1e-3 * missing:.3g} s" in " ".join(found.notes)


def test_a_speed_that_ended_before_contact_is_named():
    truth, contact = session(), 1e-9 * session().contacts[2]
    there = np.abs(1e-9 * truth.beats - contact + 0.04) > 0.04
    found = impacts_of(Series(truth.time, truth.force), Series(truth.beats[there], truth.velocity[there]))
    check(found, but=(2,))
    assert "the last speed before it is" in "; ".join(found.cuts[2].remarks)

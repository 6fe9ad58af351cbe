"""Clocks of every kind: each sample at its time, or a refusal that names what is wrong with the clock."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sessions import FEW, Made, columns, made, write_bag
from test_rough_recordings import RATE, check

from acf_jax.errors import InputError
from acf_jax.recording import Impacts, Mapping, find_impacts, opened, read_session
from acf_jax.recording.clock import settle
from acf_jax.recording.impacts import Refused
from acf_jax.recording.sampling import sampling_fault
from acf_jax.recording.series import Channel, Series, in_order, is_set_back
from tests.dataset.impacts import RIG

MAPPING = Mapping(force="f", velocity="v", pretension="p")
AMID = 1e-9 * made(3, FEW, rate=RATE).contacts[4] + 0.003  # s, in a contact
SECOND = 10**9
US = 1000  # ns


class Played:
    """A bag whose three topics are read in the order of the recorder's times, as rosbags does."""

    def __init__(self, **topics: Series):
        self.topics = topics

    def close(self) -> None: ...

    def channels(self) -> list[Channel]:
        return [Channel(name, "", series.time.size) for name, series in self.topics.items()]

    def is_position(self, source) -> bool:
        return False

    def unit(self, source) -> str:
        return ""

    def described(self, source) -> str:
        return source.name

    def read(self, sources, progress) -> dict[str, Series]:
        return {key: self.topics[source.name] for key, source in sources.items()}


def topic(time: np.ndarray, value: np.ndarray, stamp, received, delay: int) -> Series:
    """Messages of times (ns), stamped by one function of seconds and recorded by another, up to `delay` ns late."""
    late = np.random.default_rng(time.size).integers(0, delay, time.size)
    stamps, arrivals = (np.rint(1e9 * clock(1e-9 * time)).astype(np.int64) for clock in (stamp, received))
    series = Series(stamps, value, arrivals + late)
    return series.at(np.argsort(series.received, kind="stable"))


def imported(
    monkeypatch, stamp, received, delay=10 * US, change=lambda series: series, truth: Made | None = None
) -> Impacts:
    """What an import makes of force and velocity with stamps and of a pretension that has none."""
    truth = truth or made(3, FEW, rate=RATE)
    force = topic(truth.time, truth.force, stamp, received, delay)
    speed = topic(truth.beats, truth.velocity, stamp, received, delay)
    pretension = topic(truth.beats, truth.pretension, received, received, delay)
    pretension = Series(pretension.received, pretension.value)
    bag = Played(f=change(force), v=change(speed), p=pretension)
    monkeypatch.setattr(opened, "open_recording", lambda *_: bag)
    return find_impacts(read_session(Path("bag"), MAPPING), MAPPING.contacts, RIG)


def wall(t):
    return 1.7e9 + t


def back(by: float, after: float = AMID, clock=wall):
    """A clock that is set back by `by` s after so many seconds."""
    return lambda t: clock(t) - by * (t > after)


# how the stamps run, how the recorder's clock runs
SIMULATED = {
    "from 0": (lambda t: t, wall),
    "at half the pace": (lambda t: t, lambda t: wall(2.0 * t)),
    "five times as fast": (lambda t: t, lambda t: wall(t / 5.0)),
    "at a pace that varies": (lambda t: t, lambda t: wall(2.0 * t + 0.3 * np.sin(3.0 * t))),
    "paused in a contact": (lambda t: t, lambda t: wall(t + 5.0 * (t > AMID))),
    "the recorder's too": (lambda t: t, lambda t: t),
}


@pytest.mark.parametrize("name", SIMULATED)
def test_simulated_time_is_a_clock(name, monkeypatch):
    check(imported(monkeypatch, *SIMULATED[name]), begin=0)


def test_simulated_time_that_is_reset_is_refused(monkeypatch):
    with pytest.raises(InputError, match=r"bag f: time steps back 1 times .* cut the recording there"):
        imported(monkeypatch, back(1.6, 1.7, lambda t: t), lambda t: wall(2.0 * t))


@pytest.mark.parametrize("by", [1.2006, 0.0406, 0.0033, 1.2, 0.04, 0.006])
def test_a_machine_whose_clock_was_set_back_is_refused(by, monkeypatch):
    """Stamps and recorder go back together, so that two stretches of time lie over one another, on one grid or two."""
    said = r"time steps back unnoticed.* cut the recording|repeat the time of another: the clock was set back"
    with pytest.raises(InputError, match=said):
        imported(monkeypatch, back(by), back(by))


def test_a_recorder_whose_clock_was_set_back(monkeypatch):
    """The stamps are sound; what has none cannot be placed."""
    with pytest.raises(InputError, match=r"bag p: has no stamps, and the recorder's clock was set back"):
        imported(monkeypatch, wall, back(0.50006))
    stated = MAPPING.model_copy(update={"pretension": 60.0})
    truth = made(3, ((0.05, 60.0), (0.2, 60.0)) * 3, rate=RATE)
    monkeypatch.setattr(f"{__name__}.MAPPING", stated)
    found = imported(monkeypatch, wall, back(0.50006), truth=truth)
    late = np.array([cut.contact.begin - int(1.7 * 10**18) for cut in found.kept]) - np.array(truth.contacts)
    assert late.size == 6 and np.abs(late).max() < 1e9 / RATE


def test_a_few_unset_stamps_are_left_out(monkeypatch):
    """Delays of more than a sample: the recorder's times would not do."""

    def stamp(t):
        return np.where(t < 0.0025, 0.0, wall(t))

    found = imported(monkeypatch, stamp, wall, delay=1200 * US)
    check(found, begin=int(1.7 * 10**18))
    assert "f: 5 of 7000 samples have no time (0) and are left out" in found.notes


def test_stamps_that_are_all_unset(monkeypatch):
    """The recorder's times do where it was quick; else they are refused, with the reason for them."""
    found = imported(monkeypatch, lambda t: 0.0 * t, wall)
    check(found, begin=int(1.7 * 10**18))
    assert "f: its stamps are unset; the times at which it was recorded are used" in found.notes
    with pytest.raises(InputError, match=r"times were set on arrival(.|\n)*its stamps are unset"):
        imported(monkeypatch, lambda t: 0.0 * t, wall, delay=5000 * US)


def again(part: slice):
    """Messages recorded once more, a recording's length later."""

    def change(series: Series) -> Series:
        twice = series.at(part)
        later = replace(twice, received=twice.received + 4 * SECOND)
        arrays = (np.r_[getattr(series, n), getattr(later, n)] for n in ("time", "value", "received"))
        both = Series(*arrays)
        return both.at(np.argsort(both.received, kind="stable"))

    return change


@pytest.mark.parametrize("part", [slice(None), slice(None, None, 7), slice(-2000, None)])
def test_copies_are_left_out(part, monkeypatch):
    """A recording that was played in a loop, and messages that were sent twice, show each contact once."""
    found = imported(monkeypatch, wall, wall, change=again(part))
    check(found, begin=int(1.7 * 10**18))
    copies = made(3, FEW, rate=RATE).time[part].size
    assert any(
        note.startswith(f"f: {copies} of {7000 + copies} samples repeat time and") for note in found.notes
    )


def test_messages_that_overtake_one_another_are_put_in_order(monkeypatch):
    check(imported(monkeypatch, wall, wall, delay=3000 * US), begin=int(1.7 * 10**18))


def test_a_value_that_is_sent_again_is_one_sample():
    """A robot's log at 125 Hz, repeated at 1 kHz with its old stamp."""
    held = np.repeat(np.arange(400), 8)
    series = Series(1 + held * 8_000_000, np.sin(held), np.arange(held.size) * 1_000_000)
    found = settle(series, "v")
    assert np.array_equal(found.time, 1 + np.arange(400) * 8_000_000) and found.received is not None


REGULAR = np.arange(20_000) * 125 * US
RNG = np.random.default_rng(0)
NOISE = RNG.normal(0.0, 1.0, REGULAR.size)


def stalled(count: int, drain: int) -> np.ndarray:
    """Times of arrival of which `count` were held up and then came every `drain` ns."""
    time, first = REGULAR.copy(), 8000
    held = slice(first, first + count)
    time[held] = np.maximum(time[held], time[first + count] - drain * np.arange(count, 0, -1))
    return time


SOUND = {
    "regular": REGULAR,
    "lossy": REGULAR[RNG.random(REGULAR.size) > 0.2],
    "lost in stretches": REGULAR[np.arange(REGULAR.size) % 500 > 30],
    "jitter": np.sort(REGULAR + RNG.normal(0.0, 40 * US, REGULAR.size).astype(np.int64)),
    "few digits": REGULAR // (100 * US) * 100 * US,
    "triggered": REGULAR + np.arange(REGULAR.size) // 300 * 2 * SECOND,
    "held up, then at once": stalled(400, 1 * US),
    "held up, then at twice the rate": stalled(4000, 63 * US),
}  # fmt: skip


@pytest.mark.parametrize("name", SOUND)
def test_sound_times_are_not_doubted(name):
    time = np.unique(SOUND[name])
    assert sampling_fault(Series(time, NOISE[: time.size]), "f", 8e-3) is None


@pytest.mark.parametrize("count", [2, 4, 50, 1000])
def test_packets_are_named(count):
    """A complete record whose samples were stamped on arrival, many at once."""
    i = np.arange(REGULAR.size)
    time = i // count * count * 125 * US + i % count * 2 * US
    said = sampling_fault(Series(time, NOISE), "f", 8e-3)
    assert f"packets of about {count}, one packet every" in said and "set on arrival" in said
    assert float(re.search(r"evenly, (\S+) ms", said)[1]) == pytest.approx(0.125, rel=0.05)


def test_two_publishers_in_turn_are_named():
    value = np.where(np.arange(REGULAR.size) % 2, 5.0, 0.0) + NOISE
    assert "those of two publishers" in sampling_fault(Series(REGULAR, value), "f", 8e-3)
    assert (
        sampling_fault(Series(REGULAR, 5.0 * np.sin(0.8 * np.pi * np.arange(REGULAR.size))), "f", 8e-3)
        is None
    )


@pytest.mark.parametrize("step_s", [1e-3, 0.3])
def test_a_table_whose_clock_was_set_back(step_s):
    time = REGULAR - round(1e9 * step_s) * (np.arange(REGULAR.size) > 9000)
    with pytest.raises(
        InputError, match=r"time steps back 1 times .* before sample 9002: the clock was reset"
    ):
        in_order(Series(time, NOISE), "f")


def test_a_clock_that_was_set_back_by_a_few_samples():
    """They could have come late, but that they then lie too densely."""
    time = REGULAR - 580 * US * (np.arange(REGULAR.size) > 9000)
    assert "from 1.124 s to 1.125 s" in sampling_fault(in_order(Series(time, NOISE), "f"), "f", 8e-3)


def test_samples_that_came_late_are_put_in_order():
    """Single ones, and a packet that was overtaken by the next."""
    order = np.arange(REGULAR.size)
    order[5000], order[5001:5004] = 5003, order[5000:5003].copy()
    order[9000:9016] = np.r_[9008:9016, 9000:9008]
    found = in_order(Series(REGULAR[order], NOISE[order]), "f")
    assert np.array_equal(found.time, REGULAR) and np.array_equal(found.value, NOISE)
    assert not is_set_back(REGULAR[order])


def test_times_that_are_not_set_in_a_table(tmp_path):
    table = columns(made(7, FEW, rate=4000.0))
    truth = made(7, FEW, rate=4000.0).contacts
    starts = {"a": 0.0, "b": 1.7e9}
    for name, start in starts.items():
        time = table["time_s"] + start
        time[: 5 if start else 1] = 0.0
        np.savez(tmp_path / f"{name}.npz", **{**table, "time_s": time})
        found = find_impacts(read_session(tmp_path / f"{name}.npz", Mapping()), Mapping().contacts, RIG)
        late = np.array([cut.contact.begin - round(1e9 * start) for cut in found.kept]) - np.array(truth)
        assert late.size == 8 and np.abs(late).max() < 250 * US
        assert any("have no time (0)" in note for note in found.notes) == bool(start)


def two_frames(tmp_path, names) -> Path:
    """A bag of one force topic with messages of two frames in turn, 5 N apart."""
    return write_bag(tmp_path / "log", made(3, FEW, rate=500.0), "mcap", frames=names)


def test_messages_of_two_frames_are_kept_apart(tmp_path):
    truth = made(3, FEW, rate=500.0)
    bag = two_frames(tmp_path, ("left", "right"))
    with pytest.raises(InputError) as caught:
        read_session(bag, Mapping())
    said = str(caught.value)
    assert "holds messages of the frames 'left', 'right' in turn; name one, as in " in said
    named = said.rpartition("as in ")[2]
    assert named == "/ft/wrench:frame_id[left].wrench.force.z"
    for i, name in enumerate(("left", "right")):
        for field in ("wrench.force.z", "z"):
            found = read_session(
                bag, Mapping.model_validate({"force": f"/ft/wrench:frame_id[{name}].{field}"})
            )
            assert np.array_equal(found.force.value, truth.force[i::2])
    with pytest.raises(InputError, match="has no messages of frame 'up'"):
        read_session(bag, Mapping.model_validate({"force": "/ft/wrench:frame_id[up]"}))


def test_a_tool_that_was_changed_is_one_sensor(tmp_path):
    n = made(3, FEW, rate=500.0).time.size
    bag = two_frames(tmp_path, ["old"] * (n // 2) + ["new"] * (n - n // 2))
    assert read_session(bag, Mapping()).force.value.size == n


def test_a_bag_whose_clock_was_set_back(tmp_path):
    """From the file on: rosbags sorts its messages by the recorder's time."""
    bag = write_bag(
        tmp_path / "log", made(3, FEW, rate=RATE), "mcap", clock=lambda t: t - 1_300_060_000 * (t > 1.6e9)
    )
    with pytest.raises(Refused, match="time steps back unnoticed") as refused:
        find_impacts(read_session(bag, Mapping()), Mapping().contacts, RIG)
    # two stretches of time in one make impacts look short
    assert not any("record it faster" in note for note in refused.value.impacts.notes)

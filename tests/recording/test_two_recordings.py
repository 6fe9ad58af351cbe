"""The force in one recording, the robot in another: on one clock by what both show, or refused with the remedy."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from sessions import BEGIN, CONDITIONS, FEW, RIG, Made, made, write_bag

from acf_jax.cli.main import commands
from acf_jax.dataset import read_dataset
from acf_jax.errors import InputError
from acf_jax.recording import Impacts, Mapping, Refused, find_impacts, read_session
from acf_jax.recording.approach import travel_of
from acf_jax.recording.series import Series
from tests.dataset.impacts import contact_force

RATE = 2000.0
LATE = 0.03  # s after contact at which the robot of these sessions stops


def session(conditions=CONDITIONS, seed=11) -> Made:
    return made(seed, conditions, rate=RATE)


def daq(folder: Path, truth: Made, name="daq.csv", more: str = "") -> Path:
    """The force alone, its clock at zero; `more` columns of zeros."""
    head = ",".join(["time", "force", *filter(None, more.split(","))])
    zeros = ",0" * (head.count(",") - 1)
    rows = [f"{t:.6f},{f:.4f}{zeros}" for t, f in zip(truth.seconds, truth.force, strict=True)]
    (folder / name).write_text("\n".join([head, *rows]))
    return folder / name


def robot(folder: Path, truth: Made, ahead=37.2, name="robot.csv", part=slice(None), unit="") -> Path:
    """Velocity, position and pretension by a clock that is `ahead`, s, or a function of the time in s."""
    b = 1e-9 * truth.beats
    time = b + (ahead(b) if callable(ahead) else ahead)
    columns = [1e3 * time if unit else time, truth.velocity, truth.position, truth.pretension]
    head = ",".join([f"stamp{unit}", "velocity", "z", "pretension"])
    np.savetxt(folder / name, np.c_[*columns][part], "%.6f", ",", header=head, comments="")
    return folder / name


def read(path: Path, other: Path | None = None, **mapping: object) -> Impacts:
    found = Mapping.model_validate(mapping)
    return find_impacts(read_session(path, found, other=other), found.contacts, None)


def check(found: Impacts, truth: Made, ahead: float | None = 37.2, but: int = 0, late: float = LATE) -> None:
    """Every contact but the first few with its speed and pretension; the offset as far as the robot's delay."""
    kept = found.kept
    assert len(kept) == len(truth.impacts) - but
    for cut, (v, f_p) in zip(kept, truth.impacts[but:], strict=True):
        assert abs(cut.velocity.value - v) < max(4.0 * cut.velocity.std, 0.01 * v)
        assert cut.pretension.value == f_p
    if ahead is not None:
        (note,) = (note for note in found.notes if "its clock is" in note)
        words = note.partition("its clock is ")[2].split()
        told = float(words[0]) * (1 if words[2] == "ahead" else -1)
        assert -0.01 < told - ahead < late + 0.005, note
        assert "standard deviation" in note


def run(*arguments: object):
    return CliRunner().invoke(commands, ["import", *map(str, arguments)], prog_name="python -m acf_jax")


def test_the_command(tmp_path):
    truth = session()
    path, other = daq(tmp_path, truth), robot(tmp_path, truth)
    (tmp_path / "rig.yaml").write_text(RIG)
    done = run(path, "--with", other, "--rig", tmp_path / "rig.yaml", "--out", tmp_path / "set")
    assert done.exit_code == 0, done.output
    assert "12 contacts in 5.1 s, 12 kept, at 6 conditions" in done.output
    assert f"{other} column 'velocity': its clock is 37.2" in done.output
    trials = read_dataset(tmp_path / "set").trials
    assert [t.pretension for t in trials] == [f_p for _, f_p in truth.impacts]
    assert [t.contact_velocity for t in trials] == pytest.approx([v for v, _ in CONDITIONS], rel=0.02)


@pytest.mark.parametrize("ahead", [37.2, -37.2, 0.0, 0.3, -86400.0, 1.7e9])
def test_any_offset(tmp_path, ahead):
    truth = session()
    check(read(daq(tmp_path, truth), robot(tmp_path, truth, ahead)), truth, ahead)


@pytest.mark.parametrize("late", [0.0, 0.01, 0.2])
def test_a_robot_that_stops_when_it_does(tmp_path, late):
    """Its speed before contact is what counts, and does not depend on when it stops."""
    truth = session()
    b, velocity = 1e-9 * truth.beats, np.random.default_rng(3).normal(0.0, 5e-4, truth.beats.size)
    for contact, (v, _) in zip(truth.contacts, truth.impacts, strict=True):
        since = b - 1e-9 * contact
        velocity[(since > -0.15) & (since < late)] += v
    truth = replace(truth, velocity=velocity)
    check(read(daq(tmp_path, truth), robot(tmp_path, truth)), truth, late=late)


def test_a_position_and_a_slower_robot(tmp_path):
    truth = session()
    position = {"recording": "robot.csv", "name": "z"}
    robot(tmp_path, truth)
    check(read(daq(tmp_path, truth), position=position), truth)
    slow = robot(tmp_path, truth, part=slice(None, None, 2))  # 62 Hz
    check(read(daq(tmp_path, truth), slow), truth)


def test_a_robot_that_speeds_up_until_contact(tmp_path):
    """What the offset is uncertain by goes into the velocity."""
    truth = session()
    b, velocity = 1e-9 * truth.beats, np.random.default_rng(3).normal(0.0, 2e-4, truth.beats.size)
    for contact, (v, _) in zip(truth.contacts, truth.impacts, strict=True):
        since = b - 1e-9 * contact
        velocity += v * (1.0 + since / 0.2) * ((since > -0.2) & (since < 0.0))
    truth = replace(truth, velocity=velocity)
    for cut, (v, _) in zip(
        read(daq(tmp_path, truth), robot(tmp_path, truth)).kept, truth.impacts, strict=True
    ):
        assert abs(cut.velocity.value - v) < 4.0 * cut.velocity.std < 0.2 * v


@pytest.mark.parametrize("first", [60, 110])
def test_a_robot_log_that_begins_late(tmp_path, first):
    """Contacts before it are not kept; the others find their own, though one more shift explains as many."""
    truth = session()
    found = read(daq(tmp_path, truth), robot(tmp_path, truth, part=slice(first, None)))
    check(found, truth, but=(first + 60) // 55 - 1)


def test_a_drift(tmp_path):
    """A clock that gains 200 us a second, over four minutes."""
    rng = np.random.default_rng(4)
    time, beats = np.arange(0.0, 220.0, 0.002), np.arange(0.0, 220.0, 0.008)
    force, velocity = rng.normal(0.0, 1.0, time.size), rng.normal(0.0, 5e-4, beats.size)
    contacts = 5.0 + 12.0 * np.arange(18) + rng.uniform(0.0, 0.5, 18)
    speeds = np.resize([0.1, 0.2, 0.3], 18)
    for contact, v in zip(contacts, speeds, strict=True):
        since, ago = time - contact, beats - contact
        force += contact_force(np.clip(since, -1.0, 0.02), v, 60.0) * (since < 0.02) + 60.0 * (
            (since > 0.04) & (since < 0.1)
        )
        velocity += v * ((ago > -0.15) & (ago < LATE)) - v * ((ago > 0.1) & (ago < 0.16))
    table = np.c_[time, force]
    np.savetxt(tmp_path / "daq.csv", table, "%.6f", ",", header="time,force", comments="")
    table = np.c_[37.2 + beats * (1.0 + 2e-4), velocity]
    np.savetxt(tmp_path / "robot.csv", table, "%.6f", ",", header="time,velocity", comments="")
    found = read(tmp_path / "daq.csv", tmp_path / "robot.csv", pretension=60)
    (note,) = (note for note in found.notes if "drifts by" in note)
    assert 170.0 < float(note.split("drifts by +")[1].split(" us/s")[0]) < 230.0
    assert [cut.velocity.value for cut in found.kept] == pytest.approx(speeds.tolist(), rel=0.02)


def test_the_mapping_names_the_recording(tmp_path):
    """From the folder of the first; a stated offset holds for all of it, and the clocks are then not compared."""
    truth = session(FEW)
    path = daq(tmp_path, truth)
    robot(tmp_path, truth, name="ur.csv", unit="_ms")
    check(read(path, velocity={"recording": "ur.csv", "name": "velocity"}), truth)
    stated = read(path, velocity={"recording": "ur.csv", "name": "velocity", "clock_offset_s": -37.2})
    assert not any("its clock" in note for note in stated.notes)
    assert [cut.pretension.value for cut in stated.kept] == [f_p for _, f_p in truth.impacts]
    robot(tmp_path, truth, name="ur.csv")
    mapping = tmp_path / "mapping.yaml"
    mapping.write_text("velocity: {recording: ur.csv, name: velocity, time: stamp, time_scale: 1.0}\n")
    done = run(path, "--mapping", mapping, "--out", tmp_path / "set")
    assert done.exit_code == 0 and "8 kept" in done.output, done.output
    mapping.write_text(
        "velocity: {name: velocity, time_scale: 1.0}\nforce: {name: force, recording: ur.csv}\n"
    )
    said = str(run(path, "--mapping", mapping, "--out", tmp_path / "set").exception)
    assert "time_scale is that of another recording" in said
    assert "the force is that of the recording itself" in str(
        run(
            path, "--mapping", write(mapping, "force: {name: force, recording: ur.csv}"), "--out", "x"
        ).exception
    )


def write(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def test_the_same_names_in_both(tmp_path):
    """Motion and pretension are those of the robot; a name given to both is told."""
    truth = session(FEW)
    path = daq(tmp_path, truth, more="velocity,pretension")
    other = robot(tmp_path, truth)
    check(read(path, other), truth)
    named = read(path, other, velocity="velocity")
    check(named, truth)
    assert any(f"velocity is in both recordings: {other} column" in note for note in named.notes)


@pytest.mark.parametrize("kinds", [("csv", "mcap"), ("mcap", "csv"), ("mcap", "mcap"), ("ros1", "npz")])
def test_files_of_any_kind(tmp_path, kinds):
    truth = session(FEW)
    force, motion = kinds
    path = (
        daq(tmp_path, truth)
        if force == "csv"
        else write_bag(tmp_path / ("a.bag" if force == "ros1" else "a"), truth, force)
    )
    if motion == "csv":
        other = robot(tmp_path, truth, 1.7e9)
    elif motion == "npz":
        other = tmp_path / "robot.npz"
        np.savez(other, t=1e-9 * truth.beats, velocity=truth.velocity, pretension=truth.pretension)
    else:
        other = write_bag(tmp_path / "robot", truth, motion, robot_clock=5.0)
    check(read(path, other), truth, None)


def test_clocks_that_are_one_stay_so(tmp_path):
    """Two bags of one computer: the recorders' times align them, and the speed agrees."""
    truth = session(FEW)
    path = write_bag(tmp_path / "force", truth, "mcap")
    other = write_bag(tmp_path / "robot", truth, "mcap", robot_clock=5.0)
    found = read(path, other)
    check(found, truth, None)
    assert any("is that of the force: its speed drops" in note for note in found.notes)
    assert np.abs(found.session.speed.time - BEGIN - truth.beats).max() < 150_000


def evenly(count: int, speeds=(0.1, 0.1)) -> Made:
    """Contacts of two speeds in turn, each as long after the one before, with peaks that tell nothing."""
    truth = made(5, tuple((speeds[i % 2], 60.0) for i in range(count)), rate=RATE)
    same = np.full(truth.force.size, 0.0)
    for first in truth.first:
        since = truth.seconds - truth.seconds[first]
        same += 150.0 * np.sin(np.pi * since / 0.012) * ((since >= 0.0) & (since < 0.012))
    return replace(truth, force=same + np.random.default_rng(0).normal(0.0, 1.0, same.size))


def test_what_does_not_tell_a_clock_is_refused(tmp_path):
    """With the remedy, and what the offset may be."""

    def said(truth: Made, part=slice(None), **mapping: object) -> str:
        with pytest.raises(Refused) as caught:
            read(daq(tmp_path, truth), robot(tmp_path, truth, part=part), **mapping)
        assert len(caught.value.impacts.cuts) == len(truth.contacts)
        assert any("as with clock_offset_s: -" in note for note in caught.value.impacts.notes)
        assert "state clock_offset_s, s to add to its times, in the --mapping file" in str(caught.value)
        return str(caught.value)

    late = said(evenly(9, (0.1, 0.2)), part=slice(60, None))
    assert "fit to it at several shifts" in late and "about -37." in late
    assert "2 contacts are too few to tell it" in said(session(FEW[:2]))
    truth = session()
    still = replace(truth, velocity=np.full(truth.beats.size, 0.1))
    assert "its speed drops at 0 of 12 contacts at best" in said(still)
    other = replace(
        truth, velocity=session(CONDITIONS[:4], seed=3).velocity[np.arange(truth.beats.size) % 200]
    )
    assert "it does not go with the peaks of the force" in said(other)


def test_shifts_that_lead_to_the_same_conditions_need_no_choice(tmp_path):
    truth = made(5, ((0.1, 60.0),) * 9, rate=RATE)
    found = read(daq(tmp_path, truth), robot(tmp_path, truth, part=slice(110, None)))
    assert any("other shifts may be right too, and give the same conditions" in note for note in found.notes)
    assert all(cut.velocity.value == pytest.approx(0.1, rel=0.02) for cut in found.kept)


def test_a_wrong_sign_is_named_and_not_aligned_away(tmp_path):
    truth = session()
    with pytest.raises(Refused, match=r"away from the part; put -1\* before its name"):
        read(
            daq(tmp_path, truth),
            robot(
                tmp_path, replace(truth, velocity=np.where(truth.velocity < 0.0, -0.1, -1.0) * truth.velocity)
            ),
        )


def test_a_pretension_of_its_own(tmp_path):
    """One that never changes needs no clock; another is asked for."""
    truth = session(FEW[:4])
    path = tmp_path / "log.csv"
    held = np.maximum(np.searchsorted(truth.beats, truth.time, "right") - 1, 0)
    table = np.c_[truth.seconds, truth.force, truth.velocity[held]]
    np.savetxt(path, table, "%.6f", ",", header="time,force,velocity", comments="")
    found = read(path, robot(tmp_path, truth), velocity={"recording": "log.csv", "name": "velocity"})
    assert [cut.pretension.value for cut in found.kept] == [60.0] * 4
    changed = replace(truth, pretension=np.linspace(50.0, 60.0, truth.beats.size))
    with pytest.raises(Refused, match="'pretension': its clock is not known, and no speed beside it tells"):
        read(path, robot(tmp_path, changed), velocity={"recording": "log.csv", "name": "velocity"})


def test_recordings_that_are_none(tmp_path):
    truth = session(FEW[:1])
    path = daq(tmp_path, truth)
    for other, message in (
        (path, "is the recording itself"),
        (tmp_path / "none.csv", "none.csv: no such file"),
        (write(tmp_path / "robot.csv", "time,v\n0,1\n"), "robot.csv: offers 'time' (column), 'v' (column)"),
    ):
        said = str(run(path, "--with", other, "--out", tmp_path / "set").exception)
        assert message in said
    robot(tmp_path, truth)
    swapped = str(run(tmp_path / "robot.csv", "--with", path, "--out", tmp_path / "set").exception)
    assert (
        f"nothing is clearly the force; name it by --force, or name {path} first, where it may be" in swapped
    )
    alone = str(run(path, "--out", tmp_path / "set").exception)
    assert "where it is in a recording of its own, name that by --with" in alone
    with pytest.raises(InputError, match=r"none\.csv: no such file"):
        read(path, velocity={"recording": "none.csv", "name": "v"})
    mapping = write(tmp_path / "mapping.yaml", 'velocity: {name: v, recording: "a\\0b"}')
    assert "no path; name a file" in str(run(path, "--mapping", mapping, "--out", tmp_path / "set").exception)


def test_a_slowdown_is_where_it_begins():
    """Of a stop within a sample and of one that takes 60 ms alike."""
    time = np.arange(0.0, 2.0, 0.008)
    for takes in (0.0, 0.06):
        value = 0.2 * np.clip((1.0 + takes - time) / max(takes, 1e-9), 0.0, 1.0) * (time > 0.5)
        travel = travel_of(Series(np.rint(1e9 * time).astype(np.int64), value), False)
        assert travel.slowdowns(np.array([0.98, 1.0, 1.02])) == pytest.approx(np.ones(3), abs=0.008)
    assert np.isnan(travel.slowdowns(np.array([0.3]))).all()


def test_each_recording_has_times_of_its_own(tmp_path):
    """By a name that both share, or by what each calls a time; `--list` shows both."""
    truth = session(FEW)
    path, other = daq(tmp_path, truth), robot(tmp_path, truth)
    path.write_text(path.read_text().replace("time,", "zeit,", 1))
    for head in ("stamp", "zeit"):
        other.write_text(other.read_text().replace("stamp", head, 1))
        done = run(path, "--with", other, "--time", "zeit", "--out", tmp_path / head)
        assert done.exit_code == 0 and "8 kept" in done.output, repr(done.exception)
    listed = run(path, "--with", other, "--time", "zeit", "--list").output
    assert (
        listed.split()
        == f"{path}: zeit column force column {other}: zeit column velocity column z column"
        " pretension column".split()
    )

"""Recordings of every kind, written by their libraries and read back: the known impacts come out as they went in."""

import csv
import json
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from needs import need_module
from sessions import BEGIN, CONDITIONS, FEW, RIG, columns, made, structured, write_bag, write_csv

from acf_jax.cli.main import commands
from acf_jax.dataset import read_dataset
from acf_jax.dataset.trials import Prior, RigPrior
from acf_jax.errors import InputError
from acf_jax.recording import Mapping, find_impacts, read_session
from acf_jax.recording.page import import_page
from tests.killed import AT_A_RENAME

RATE = 4000.0
TYPICAL = RigPrior(Prior(2.1, 0.04), Prior(60.0, 18.0), Prior(800.0, 500.0), Prior(3.4e5, 4e4))


def session():
    return made(7, FEW, rate=RATE)


def as_csv(folder: Path):
    return write_csv(folder / "log.csv", session()), {}


def as_decimal_commas(folder: Path):
    names = ("t_s", "Kraft", "v", "p")
    path = write_csv(folder / "log.csv", session(), ";", names)
    return path, {"force": "Kraft", "velocity": "v", "pretension": "p", "time": "t_s"}


def as_npz(folder: Path):
    """Arrays of two rates, each with times of its own; a position to differentiate."""
    s = session()
    path = folder / "log.npz"
    times = {"time_ns": s.time, "robot_ns": s.beats}
    np.savez(path, **times, f=s.force, z=1000.0 * s.position, preload=s.pretension)
    position = {"name": "z", "scale": 0.001, "time": "robot_ns"}
    pretension = {"name": "preload", "time": "robot_ns"}
    return path, {"force": "f", "position": position, "pretension": pretension, "time": "time_ns"}


def as_npy(folder: Path):
    np.save(folder / "log.npy", structured(columns(session())))
    return folder / "log.npy", {}


def as_parquet(folder: Path):
    parquet = need_module("pyarrow.parquet", "pip install 'acf-jax[parquet]'")
    import pyarrow

    table = columns(session())
    stamps = np.datetime64("2026-03-01T10:00:00", "ns") + session().time
    arrays = {"timestamp": stamps, **{k: v for k, v in table.items() if k != "time_s"}}
    parquet.write_table(pyarrow.table(arrays), folder / "log.parquet")
    return folder / "log.parquet", {}


def as_mcap(folder: Path):
    """One clock 37 s ahead and drifting by 100 us a second."""
    path = write_bag(folder / "log", session(), "mcap", robot_clock=37.0, robot_drift=1e-4)
    return path / "log.mcap", {}


def as_sqlite3(folder: Path):
    return write_bag(folder / "log", session(), "sqlite3", speed="pose"), {}


def as_ros1(folder: Path):
    path = write_bag(folder / "log.bag", session(), "ros1", speed="joints")
    return path, {"velocity": "/robot/state:velocity[lift]"}


KINDS = [as_csv, as_decimal_commas, as_npz, as_npy, as_parquet, as_mcap, as_sqlite3, as_ros1]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_known_impacts_come_back(kind, tmp_path):
    truth = session()
    path, mapping = kind(tmp_path)
    recording = read_session(path, Mapping.model_validate(mapping))
    impacts = find_impacts(recording, Mapping().contacts, TYPICAL)
    assert [cut.keep for cut in impacts.cuts] == [True] * len(FEW)
    sample = round(1e9 / RATE)
    for cut, contact, first, (v, f_p) in zip(
        impacts.cuts, truth.contacts, truth.first, truth.impacts, strict=True
    ):
        before = int(np.count_nonzero(cut.time < 0))
        part = slice(first - before, first - before + cut.time.size)
        assert before >= 40 and cut.time[-1] > 55_000_000
        assert abs(cut.zero) < 0.2 and np.array_equal(cut.force, truth.force[part] - cut.zero)  # bit for bit
        since = truth.time[part] - contact
        assert np.abs(cut.time - since).max() < sample
        assert np.ptp(cut.time - since) <= 1  # ns
        assert abs(cut.velocity.value - v) < 4.0 * cut.velocity.std
        assert cut.velocity.std < 0.02 * v + 1e-3
        assert cut.condition[1] == f_p and cut.condition[0] == pytest.approx(v, rel=0.03)
    assert len({cut.condition for cut in impacts.cuts}) == 4


def test_a_table_of_dates(tmp_path):
    """As loggers write them; one of another form is named."""
    path, _ = as_csv(tmp_path)
    head, *rows = path.read_text().splitlines()
    stamps = np.datetime64("2026-03-01T10:00:00", "ns") + [
        round(1e9 * float(row.split(",")[0])) for row in rows
    ]
    rows = [f"{stamp}Z,{row.partition(',')[2]}" for stamp, row in zip(stamps.astype(str), rows, strict=True)]
    path.write_text("\n".join([head, *rows]))
    for day in ("2026-03-01T", "1.3.2026 ", ""):
        path.write_text("\n".join([head, *(row.replace("2026-03-01T", day) for row in rows)]))
        assert len(find_impacts(read_session(path, Mapping()), Mapping().contacts, TYPICAL).kept) == len(FEW)
    path.write_text("\n".join([head, *(row.replace("2026-03-01T", "3/1/2026 ") for row in rows)]))
    said = refused(tmp_path, path)
    assert "row 2: time_s is '3/1/2026 10:" in said and "write them as 2026-03-01T10:00:00" in said


def test_a_transform_is_that_of_its_frame(tmp_path):
    """Every message holds two; without a frame none is taken."""
    bag = write_bag(tmp_path / "log", session(), "mcap", speed="transforms")
    frame = "/robot/state:transforms[tool0].transform.translation.z"
    mapping = Mapping.model_validate({"position": frame})
    cuts = find_impacts(read_session(bag, mapping), Mapping().contacts, TYPICAL).kept
    assert len(cuts) == len(FEW)
    for cut, (v, _) in zip(cuts, session().impacts, strict=True):
        assert abs(cut.velocity.value - v) < 4.0 * cut.velocity.std
    said = refused(tmp_path, bag, "--position", "/robot/state:transforms[0].transform.translation.z")
    assert "has no child frame '0'; name one of 'base', 'tool0'" in said
    assert "holds transforms of many frames; name one" in refused(tmp_path, bag, "--velocity", "/robot/state")


def test_a_clock_that_was_never_set(tmp_path):
    path = write_bag(tmp_path / "log", session(), "mcap", stamped=False)
    recording = read_session(path, Mapping())
    assert any("unset" in note for note in recording.notes)
    impacts = find_impacts(recording, Mapping().contacts, TYPICAL)
    assert len(impacts.kept) == len(FEW)
    assert impacts.session.force.time[0] == pytest.approx(BEGIN, abs=200_000)


def test_a_clock_that_is_a_little_ahead(tmp_path):
    """Noted and mended, unless the user says what it is."""
    few = made(7, FEW[:3], rate=1000.0)
    path = write_bag(tmp_path / "log", few, "mcap", robot_clock=0.05)
    mended = read_session(path, Mapping())
    assert np.abs(mended.speed.time - BEGIN - few.beats).max() < 30_000
    assert "0.05 s ahead of that of the force" in mended.notes[-1]
    stated = {"name": "/robot/state", "field": "twist.linear.z", "clock_offset_s": 0.0}
    kept = read_session(path, Mapping.model_validate({"velocity": stated}))
    assert np.array_equal(kept.speed.time, BEGIN + few.beats + 50_000_000)


def run(*arguments: object):
    return CliRunner().invoke(commands, ["import", *map(str, arguments)], prog_name="python -m acf_jax")


def test_the_command(tmp_path):
    """Import, review, import again; a data set that `diagnose` reads."""
    path, _ = as_csv(tmp_path)
    rig, review, out = tmp_path / "rig.yaml", tmp_path / "cuts.yaml", tmp_path / "set"
    rig.write_text(RIG)
    first = run(path, "--out", out, "--rig", rig, "--review", review)
    assert first.exit_code == 0, first.output
    assert "8 contacts in 3.5 s, 8 kept, at 4 conditions" in first.output
    data = read_dataset(out)
    assert len(data.trials) == 8 and len(data.conditions) == 4
    cut = find_impacts(read_session(path, Mapping()), Mapping().contacts, TYPICAL).cuts[3]
    assert np.array_equal(data.trials[3].trace.force, cut.force)
    assert data.trials[3].peak_force == cut.force[cut.time >= 0][: round(0.02 * RATE)].max()
    assert float(data.trials[3].other["measured_velocity_m_per_s"]) == pytest.approx(
        cut.velocity.value, rel=1e-5
    )

    text = review.read_text()
    again = run(path, "--out", tmp_path / "again", "--rig", rig, "--review", review)
    assert again.exit_code == 0 and review.read_text() == text
    for file in ("dataset.yaml", "trials.csv", *(f"traces/t{i:03d}.csv" for i in range(8))):
        assert (out / file).read_bytes() == (tmp_path / "again" / file).read_bytes()

    entries = yaml.safe_load(text)["cuts"]
    moved = entries[1]["contact_s"] + 0.002
    lines = text.replace(f"{entries[1]['contact_s']:.9f}", f"{moved:.9f}").splitlines()
    lines = [line.replace("keep: true", "keep: false") if "t005" in line else line for line in lines]
    review.write_text("\n".join(line for line in lines if "t006" not in line) + "\n")
    (out / "traces" / "mine.csv").write_text("a note")
    other = run(path, "--out", out, "--rig", rig, "--review", review)
    assert other.exit_code == 0 and "t005 is not kept: dropped by hand" in other.output
    changed = read_dataset(out)
    left = {file.stem for file in (out / "traces").iterdir()}
    assert left == {"mine", *(t.name for t in changed.trials)}  # no trace of a cut that is gone
    assert [t.name for t in changed.trials] == ["t000", "t001", "t002", "t003", "t004", "t007"]
    late = data.trials[1].trace.time[0] - changed.trials[1].trace.time[0]
    assert changed.trials[1].other["contact_s"] == f"{moved:.9f}" and abs(late) < 0.0025


def test_without_a_rig_there_is_a_template(tmp_path):
    path, _ = as_npy(tmp_path)
    done = run(path, "--out", tmp_path / "set")
    page = (tmp_path / "set" / "import.html").read_text()
    assert "save cuts.yaml, then import again with --review cuts.yaml" in page
    assert done.exit_code == 0 and "fill in the rig" in done.output
    with pytest.raises(InputError, match=r"rig.moving_mass_kg.value: must be a number, but is empty"):
        read_dataset(tmp_path / "set")
    description = tmp_path / "set/dataset.yaml"
    stated = "measurement: {force_noise_std_n: 1.5, contact_velocity_rel_std: 0.2}\n"
    description.write_text(f"schema: acf-gap-dataset/1\ndescription: flange 2\n{RIG}{stated}")
    assert run(path, "--out", tmp_path / "set").exit_code == 0  # keeps what was filled in
    assert read_dataset(tmp_path / "set").rig.m == Prior(2.1, 0.04)
    again = yaml.safe_load(description.read_text())
    assert again["description"] == "flange 2" and again["measurement"]["force_noise_std_n"] == 1.5
    assert again["measurement"].get("contact_velocity_rel_std", 0.0) < 0.02  # measured anew
    half = description.read_text().replace("value: 2.1", "value: two")
    description.write_text(half)
    assert "rig.moving_mass_kg.value" in str(run(path, "--out", tmp_path / "set").exception)
    assert description.read_text() == half  # nothing that a user wrote is lost


KILLED = AT_A_RENAME + "from acf_jax.cli.main import main; main()"


@pytest.mark.parametrize("at", [4, 15, pytest.param(28, marks=pytest.mark.long)])
def test_an_import_that_was_killed_is_recovered(tmp_path, at):
    """While it wrote, while the earlier data set was moved aside, while its own was moved in: the rig stays known."""
    path, _ = as_npy(tmp_path)
    rig, out = tmp_path / "rig.yaml", tmp_path / "set"
    rig.write_text(RIG)
    assert run(path, "--out", out, "--rig", rig).exit_code == 0
    before = {file.name for file in out.iterdir()}
    command = [sys.executable, "-c", KILLED, str(at), "import", str(path), "--out", str(out)]
    killed = subprocess.run(command, capture_output=True, check=False)
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    assert {file.name for file in out.iterdir()} != before
    done = run(path, "--out", out)
    assert done.exit_code == 0 and "next: python -m acf_jax diagnose" in done.output, repr(done.exception)
    assert {file.name for file in out.iterdir()} == before
    assert read_dataset(out).rig.m == Prior(2.1, 0.04)


def test_json_names_the_cuts(tmp_path):
    path, _ = as_npy(tmp_path)
    found = json.loads(run(path, "--out", tmp_path / "set", "--json").output)
    contacts = 1e-9 * (np.array(session().contacts) - session().time[0])
    assert [cut["contact_s"] for cut in found["cuts"]] == pytest.approx(contacts.tolist(), abs=1 / RATE)


def test_a_data_set_of_another_origin_stays(tmp_path):
    path, _ = as_npy(tmp_path)
    (tmp_path / "set").mkdir()
    (tmp_path / "set/trials.csv").write_text("mine")
    done = run(path, "--out", tmp_path / "set")
    assert "that no import wrote" in str(done.exception)
    assert (tmp_path / "set/trials.csv").read_text() == "mine"


def refused(tmp_path, path, *options: object) -> str:
    """What an import of `path` that fails says; no data set may be left behind."""
    out = tmp_path / "refused"
    done = run(path, "--out", out, *options)
    assert isinstance(done.exception, InputError), done.output + repr(done.exception)
    assert not out.exists() or [file.name for file in out.iterdir()] == ["import.html"]
    assert not list(tmp_path.glob(".refused*"))
    return str(done.exception)


def with_columns(tmp_path, **changes) -> Path:
    table = columns(session())
    table |= {name: change(table[name]) for name, change in changes.items()}
    np.savez(tmp_path / "log.npz", **table)
    return tmp_path / "log.npz"


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"force_n": lambda f: -f}, "negative in contact"),
        ({"force_n": lambda f: f / 9.80665}, "in kgf, put 9.80665\\* before its name"),
        ({"force_n": lambda f: 101.97 * f}, "in gf, put 0.00980665\\* before its name"),
        ({"force_n": lambda f: 1000.0 * f}, "in mN, put 0.001\\*"),
        ({"force_n": lambda f: 0.001 * f}, "in kN, put 1000\\*"),
        (
            {"pretension_n": lambda p: 40.0 * p},
            r"\); if the pretension is in gf, put 0.00980665\* before its name",
        ),
        ({"pretension_n": lambda p: 102.0 * p}, "if it is in gf, multiply by 0.0098"),
        ({"velocity_m_per_s": lambda v: 1000.0 * v}, "if it is in mm/s, put 0.001\\*"),
        ({"velocity_m_per_s": lambda v: -v}, "away from the part; put -1\\*"),
        ({"velocity_m_per_s": lambda v: 0.0 * v}, "stands still before contact"),
        ({"pretension_n": lambda p: -p}, "put -1\\* before its name"),
        ({"pretension_n": lambda p: 0.001 * p}, "in kN"),
        ({"time_s": lambda t: 1e3 * t}, "if its times are in ms, set time_scale"),
        ({"time_s": lambda t: 1e-4 * t}, "beyond any sensor"),
        ({"time_s": lambda t: t[::-1]}, "time steps back .* recordings are strung together: cut"),
        ({"time_s": lambda t: t + 3e-4 * np.sin(np.arange(t.size) * 2.5)}, "stamps jitter: name the times"),
        ({"time_s": lambda t: np.round(t)}, "repeat the time of another"),
        ({"force_n": lambda f: np.where(f > 50.0, np.inf, f)}, "not finite numbers"),
    ],
)
def test_units_and_signs_are_named(tmp_path, changes, message):
    path = with_columns(tmp_path, **changes)
    said = refused(tmp_path, path)
    assert re.search(message, said), said


@pytest.mark.parametrize(
    "rate, conditions, message",
    [
        (51_200.0, FEW[:4], "where 16 are needed.*"),
        (102_400.0, FEW[:4], "the force rises for.*"),
        (102_400.0, FEW, "record it faster.*"),
    ],
)
def test_times_in_ms_of_a_fast_sensor_are_named(tmp_path, rate, conditions, message):
    """What reads as 50 or 100 Hz, at which an import may be all that there is."""
    table = columns(made(7, conditions, rate=rate))
    np.savez(tmp_path / "log.npz", **table | {"time_s": 1e3 * table["time_s"]})
    said = refused(tmp_path, tmp_path / "log.npz")
    assert re.search(message + "if its times are in ms, set time_scale: 1.0e-3", said), said


@pytest.mark.parametrize("noise", ["white", "held", "seldom"])
def test_a_pretension_that_is_noise_about_zero_is_none(tmp_path, noise):
    """Alone, and in the lower of two conditions; what is small but clear stays."""
    rng = np.random.default_rng(1)

    def noisy(f_p):
        every = {"white": 1, "held": 64, "seldom": 400}[noise]
        return f_p + np.repeat(rng.normal(0.0, 0.05, f_p.size // every + 1), every)[: f_p.size]

    for change, expected in (
        (lambda p: noisy(0.0 * p), {0.0}),
        (lambda p: noisy(np.where(p > 80.0, 100.0, 0.03)), {0.0, 100.0}),
        (lambda p: np.where(p > 80.0, 20.0, 0.7), {0.7, 20.0}),
    ):
        path = with_columns(tmp_path, pretension_n=change)
        impacts = find_impacts(read_session(path, Mapping()), Mapping().contacts, TYPICAL)
        assert {round(cut.condition[1], 0 if cut.condition[1] > 1 else 3) for cut in impacts.kept} == expected


def test_recordings_strung_together_are_named(tmp_path):
    """One step back in thousands of samples, small or large, is no late sample."""
    table, other = columns(session()), columns(made(8, FEW, rate=RATE))
    for shift in (0.0, 2.0):
        twice = {name: np.r_[column, other[name]] for name, column in table.items()}
        twice["time_s"] = np.r_[table["time_s"], table["time_s"] + shift]
        np.savez(tmp_path / "log.npz", **twice)
        said = refused(tmp_path, tmp_path / "log.npz")
        assert f"before sample {table['time_s'].size + 1}: the clock was reset or recordings" in said


@pytest.mark.parametrize("offset", [-400.0, -3.0, 25.0])
def test_zero_is_taken_off_a_sensor_that_was_never_tared(tmp_path, offset):
    """Of traces and peaks, by default; `--no-tare`, or the mapping, keeps the readings."""
    np.savez(tmp_path / "log.npz", **columns(made(3, FEW, offset=offset)))
    np.savez(tmp_path / "zeroed.npz", **columns(made(3, FEW)))
    (tmp_path / "rig.yaml").write_text(RIG)
    (tmp_path / "map.yaml").write_text("contacts: {tare: false}\n")

    def imported(name, *options):
        out = tmp_path / "set"
        done = run(tmp_path / name, "--out", out, "--rig", tmp_path / "rig.yaml", *options)
        assert done.exit_code == 0, done.output
        return read_dataset(out).trials, done.output

    trials, said = imported("log.npz")
    assert ("N before contact: taken off" in said) == (abs(offset) > 2.9)
    assert "Data: nothing speaks against them" in said
    zeroed, _ = imported("zeroed.npz")
    for a, b in zip(trials, zeroed, strict=True):
        assert np.allclose(a.trace.force, b.trace.force, atol=1e-9)
        assert a.peak_force == pytest.approx(b.peak_force, abs=1e-9)
    for options in (["--no-tare"], ["--mapping", tmp_path / "map.yaml"]):
        kept, said = imported("log.npz", *options)
        assert "limited by offset" in said and "zero it before each trial" in said
        zeros = [k.trace.force - t.trace.force for k, t in zip(kept, trials, strict=True)]
        assert np.allclose(zeros, offset, atol=0.2)
        if offset < -100.0:  # peaks below zero stay in the traces: the data set is one that can be read
            assert all(trial.peak_force is None for trial in kept)
    again, _ = imported("log.npz", "--mapping", tmp_path / "map.yaml", "--tare")
    assert again[0].peak_force == trials[0].peak_force


def test_the_end_of_the_range_stays_one_reading(tmp_path):
    """Each contact's approach tells another zero within the noise: readings that are equal stay so."""
    table = columns(made(3, CONDITIONS, offset=12.0))
    table["force_n"] = np.minimum(table["force_n"], 212.0)
    np.savez(tmp_path / "log.npz", **table)
    (tmp_path / "rig.yaml").write_text(RIG)
    done = run(tmp_path / "log.npz", "--out", tmp_path / "set", "--rig", tmp_path / "rig.yaml")
    assert done.exit_code == 0 and "Data: limited by saturation; 12 trials" in done.output, done.output
    tops = {
        trial.peak_force for trial in read_dataset(tmp_path / "set").trials if trial.contact_velocity > 0.3
    }
    assert len(tops) == 1 and tops.pop() == pytest.approx(200.0, abs=0.1)


def test_a_drifting_sensor_has_a_zero_for_each_contact(tmp_path):
    np.savez(tmp_path / "log.npz", **columns(made(3, FEW, drift=-20.0)))
    (tmp_path / "rig.yaml").write_text(RIG)
    done = run(tmp_path / "log.npz", "--out", tmp_path / "set", "--rig", tmp_path / "rig.yaml")
    trials = read_dataset(tmp_path / "set").trials
    assert done.exit_code == 0 and "before contact: taken off" in done.output
    before = [float(np.median(t.trace.force[t.trace.time < 0])) for t in trials]
    assert np.abs(before).max() < 3.0  # the drift by itself is 60 N


def test_cuts_that_are_moved_earlier(tmp_path):
    """A cut that is moved is still that contact: it ends and peaks where it did."""
    path, _ = as_npy(tmp_path)
    review = tmp_path / "cuts.yaml"
    assert run(path, "--out", tmp_path / "set", "--review", review).exit_code == 0
    before = read_trials(tmp_path / "set")
    document = yaml.safe_load(review.read_text())
    for entry in document["cuts"]:
        entry["contact_s"] = round(entry["contact_s"] - 5e-4, 9)
    review.write_text(yaml.safe_dump(document))
    done = run(path, "--out", tmp_path / "set", "--review", review)
    assert done.exit_code == 0 and "doubtful" not in done.output, done.output
    peaks = [[float(row["peak_force_n"]) for row in rows] for rows in (read_trials(tmp_path / "set"), before)]
    assert peaks[0] == pytest.approx(peaks[1], abs=0.05)  # another approach tells another zero


def read_trials(folder: Path) -> list[dict[str, str]]:
    with (folder / "trials.csv").open() as file:
        return list(csv.DictReader(file))


def test_parquet_that_arrow_cannot_turn(tmp_path):
    need_module("pyarrow", "pip install 'acf-jax[parquet]'")
    import pyarrow
    from pyarrow import parquet

    table = columns(session())
    late = pyarrow.array([2**55, None], pyarrow.timestamp("ms"))
    names = ["timestamp", "force_n", "velocity_m_per_s", "pretension_n"]
    few = [late, *(pyarrow.array(table[name][:2]) for name in names[1:])]
    parquet.write_table(pyarrow.table(few, names=names), tmp_path / "late.parquet")
    assert "cannot be read" in refused(tmp_path, tmp_path / "late.parquet")
    names[2] = "force_n"
    parquet.write_table(pyarrow.table(few, names=names), tmp_path / "twice.parquet")
    twice = refused(tmp_path, tmp_path / "twice.parquet")
    assert "'force_n (1)', 'force_n (2)' may all be the force; name it by --force" in twice
    one = refused(tmp_path, tmp_path / "twice.parquet", "--force", "force_n", "--velocity", "1")
    assert "column 'force_n': is there 2 times; name one of 'force_n (1)', 'force_n (2)'" in one


def test_the_time_column_counts_in_a_list(tmp_path):
    table = columns(session())
    np.savez(tmp_path / "log.npz", stamp0=table.pop("time_s"), **table)
    assert "force_n" in run(tmp_path / "log.npz", "--list", "--time", "stamp0").output


def test_a_scale_mends_a_unit(tmp_path):
    path = with_columns(tmp_path, force_n=lambda f: -f, velocity_m_per_s=lambda v: 1000.0 * v)
    mapping = tmp_path / "mapping.yaml"
    mapping.write_text("force: '-1*force_n'\nvelocity: {name: velocity_m_per_s, scale: 0.001}\n")
    assert run(path, "--out", tmp_path / "set", "--mapping", mapping).exit_code == 0
    done = run(path, "--out", tmp_path / "b", "--force", "-1*force_n", "--velocity", "0.001*velocity_m_per_s")
    assert done.exit_code == 0, done.output


def test_what_has_to_be_named_is_listed(tmp_path):
    table = columns(session())
    np.savez(tmp_path / "log.npz", **table, force_2=table["force_n"])
    said = refused(tmp_path, tmp_path / "log.npz")
    assert "'force_n', 'force_2' may all be the force; name it by --force" in said
    assert "'force_2' (float64)" in said
    assert "did you mean 'force_n'" in refused(tmp_path, tmp_path / "log.npz", "--force", "force_m")
    bag = write_bag(tmp_path / "bag", session(), "mcap", axis="x")
    assert "shows no contact" in refused(tmp_path, bag)
    assert "/ft/wrench" in run(bag, "--list").output
    assert run(bag, "--out", tmp_path / "set", "--force", "/ft/wrench:x").exit_code == 0
    assert "has no topic '/ft'" in refused(tmp_path, bag, "--force", "/ft")
    assert "has no field 'wrench.force.w'" in refused(tmp_path, bag, "--force", "/ft/wrench:wrench.force.w")
    assert "is not a number" in refused(tmp_path, bag, "--force", "/ft/wrench:wrench.force")
    joints = write_bag(tmp_path / "joints", session(), "mcap", speed="joints")
    assert "velocity[NAME]: 'turn', 'lift'" in refused(tmp_path, joints)


def test_joints_of_two_publishers(tmp_path):
    """Messages without the joint are passed over; without a name, or with a wrong one, the joints are listed."""
    bag = write_bag(tmp_path / "bag", session(), "mcap", speed="two_publishers")
    arm = read_session(bag, Mapping.model_validate({"velocity": "/robot/state:velocity[lift]"}))
    others = np.arange(session().beats.size) % 3 != 0
    assert np.array_equal(arm.speed.value, session().velocity[others])
    both = "'gripper', 'lift', 'turn'"
    assert f"has no joint 'left'; name one of {both}" in refused(
        tmp_path, bag, "--velocity", "/robot/state:velocity[left]"
    )
    first = "/robot/state:velocity[0]"
    assert f"name one as velocity[NAME]: {both}" in refused(tmp_path, bag, "--velocity", first)


def test_faults_of_mapping_and_review_come_together(tmp_path):
    path, _ = as_npy(tmp_path)
    mapping = tmp_path / "mapping.yaml"
    mapping.write_text("forse: a\nvelocity: {name: v, scale: 0}\ncontacts: {before_s: -1}\n")
    (tmp_path / "rig.yaml").write_text("rig: {moving_mass_kg: {value: 2100, std: 1}}\n")
    said = refused(tmp_path, path, "--mapping", mapping, "--rig", tmp_path / "rig.yaml")
    for part in (
        "did you mean 'force'",
        "scale must not be 0",
        ": contacts.before_s: must be greater than 0, but is -1",
        "divide by 1000",
    ):
        assert part in said
    mapping.write_text("velocity: {nam: v}\npretension: [60]\n")
    faults = refused(tmp_path, path, "--mapping", mapping).splitlines()
    for fault, part in zip(
        faults,
        (
            ": velocity.name: is missing",
            ": velocity.nam: is not a known key; did you mean 'name'",
            ": pretension: is [60], neither",
        ),
        strict=True,
    ):
        assert part in fault
    said = refused(tmp_path, path, "--velocity", "0*v", "--pretension", "60")
    assert said.startswith("--velocity: scale must not be 0")
    review = tmp_path / "cuts.yaml"
    cut = "{trial: a, contact_s: 1.0, keep: true}"
    review.write_text(f"schema: acf-import-cuts/1\nrecording: x\ncuts: [{cut}, {cut}]\n")
    said = refused(tmp_path, path, "--review", review)
    assert "is 'x', not 'log.npy'" in said and "is there twice" in said


def test_a_wrong_review_is_named_before_anything_is_written(tmp_path):
    path, _ = as_npy(tmp_path)
    begins = [1e-9 * contact for contact in session().contacts[:3]]
    times = {"a": begins[0], "b": begins[1], "c": begins[2], "back": begins[0] + 0.13}
    cuts = ", ".join(f"{{trial: {name}, contact_s: {time}, keep: true}}" for name, time in times.items())
    review = tmp_path / "cuts.yaml"
    review.write_text(f"schema: acf-import-cuts/1\nrecording: log.npy\ncuts: [{cuts}]\n")
    said = refused(tmp_path, path, "--review", review)
    assert re.fullmatch(r".*cuts.yaml trial 'back': the robot moves at -0.0\d+ m/s there, .*", said), said
    done = run(path, "--out", tmp_path / "set", "--review", path / "cuts.yaml")
    assert isinstance(done.exception, OSError) and not (tmp_path / "set").exists()


def test_a_missing_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rosbags", None)
    (tmp_path / "log.mcap").write_bytes(b"")
    assert "pip install 'acf-jax[ros]'" in refused(tmp_path, tmp_path / "log.mcap")


def test_text_from_a_recording_is_text_on_the_page(tmp_path):
    path = with_columns(tmp_path)
    evil = path.rename(tmp_path / "<img src=x onerror=alert(1)>.npz")
    impacts = find_impacts(read_session(evil, Mapping()), Mapping().contacts, TYPICAL)
    assert "<img" not in import_page(impacts, "<img>", "<img>")


def test_tables_are_joined_as_the_documentation_says(tmp_path, monkeypatch):
    page = (Path(__file__).parents[2] / "docs/import.md").read_text("utf-8")
    code = re.search(r"^## Several recordings.*?^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    monkeypatch.chdir(tmp_path)
    for f_p in (40.0, 90.0):
        s = columns(made(7, tuple((v, f_p) for v in (0.05, 0.2, 0.3)), rate=RATE))
        log = np.c_[1e3 * s["time_s"], -s["force_n"], 1e3 * s["velocity_m_per_s"]]
        np.savetxt(f"at_{f_p:g}N.csv", log, delimiter=",", header="t_ms,Fz,v_tcp_mm_s", comments="")
    exec(code[1], {})
    found = find_impacts(read_session(Path("session.npz"), Mapping()), Mapping().contacts, TYPICAL)
    assert [c.keep for c in found.cuts] == [True] * 6
    assert [c.condition[1] for c in found.cuts] == [40.0] * 3 + [90.0] * 3

"""A recording of which no data set can come leaves a page, the contacts and every reason, and no data set."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from sessions import FEW, RIG, columns, made

from acf_jax.cli.main import commands
from acf_jax.dataset import read_dataset
from acf_jax.errors import InputError
from acf_jax.folders import read_folder

RATE = 2000.0
N = len(FEW)


def session():
    return made(7, FEW, rate=RATE)


def log(folder: Path, **changes) -> Path:
    """The session as a table, its columns changed, or taken away by None."""
    table = columns(session())
    for name, change in changes.items():
        column = table.pop(name)
        if change is not None:
            table[name] = change(column)
    np.savez(folder / "log.npz", **table)
    return folder / "log.npz"


def run(*arguments: object):
    return CliRunner().invoke(commands, ["import", *map(str, arguments)], prog_name="python -m acf_jax")


def first_touches(count: int):
    """Silence after the first contacts."""
    end = session().first[count] - round(0.1 * RATE)
    return lambda f: np.where(np.arange(f.size) < end, f, f[np.arange(f.size) % 400])


# what is wrong, what is said, how many contacts are listed and what stands beside each
REFUSALS = {
    "too few": ({"force_n": first_touches(2)}, (), r"2 of 2 contacts can be used; .*: record more$", 2, "can be used"),
    "wrong sign": (
        {"force_n": lambda f: -f}, (), r"negative in contact .*; put -1\* before its name$", N, "can be used",
    ),
    "sign turned already": (
        {}, ("--force=-1*force_n",), r"; its sign was turned by -1\*: take -1\* away$", N, "can be used",
    ),
    "velocity turned": (
        {"velocity_m_per_s": lambda v: -v}, (), r"away from the part; put -1\* before its name, or", N,
        "does not approach",
    ),
    "velocity turned already": (
        {}, ("--velocity=-1*velocity_m_per_s",), r"its sign was turned by -1\*: take -1\* away, or state", N,
        "does not approach",
    ),
    "turned and scaled already": (
        {"velocity_m_per_s": lambda v: 1000.0 * v}, ("--velocity=-0.001*velocity_m_per_s",),
        r"put 0.001\* before its name in place of -0.001\*, since its sign was turned", N, "does not approach",
    ),
    "scaled the wrong way": (
        {}, ("--velocity=1000*velocity_m_per_s",), r"if it is in mm/s, it was scaled by 1000\*: take 1000\* away", N,
        "",
    ),
    "a number turned": ({}, ("--velocity=-0.1",), r"away from the part; give 0.1 m/s, or", N, "does not approach"),
    "pretension turned": (
        {}, ("--pretension=-1*pretension_n",), r"its sign was turned by -1\*: take -1\* away", N, "the pretension is -",
    ),
    "no speed": (
        {"velocity_m_per_s": lambda v: np.where(np.arange(v.size) > v.size - 100, v, np.nan)}, (),
        "velocity.*has no samples before any contact", N, "no speed was recorded before it",
    ),
    "no pretension": (
        {"pretension_n": lambda p: np.where(np.arange(p.size) > p.size - 100, p, np.nan)}, (),
        "pretension.*has no value before any contact", N, "no pretension was recorded before it",
    ),
    "no contact": ({"force_n": lambda f: f[np.arange(f.size) % 400]}, (), "shows no contact", 0, ""),
    "too slow": ({"time_s": lambda t: 50.0 * t}, (), "where 16 are needed; .* record it faster, at 4 kHz", None, ""),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSALS)
def test_what_was_found_is_left_to_look_at(name, tmp_path):
    changes, options, message, count, beside = REFUSALS[name]
    out, cuts = tmp_path / "out", tmp_path / "cuts.yaml"
    done = run(log(tmp_path, **changes), "--out", out, "--review", cuts, *options)
    assert isinstance(done.exception, InputError), repr(done.exception)
    assert re.search(message, done.exception.faults[0]), done.exception
    assert [file.name for file in out.iterdir()] == ["import.html"]
    page = (out / "import.html").read_text()
    assert "Why no data set came of it" in page and "log.npz" in page
    listed = re.findall(r"^t\d{3} at .*", done.output, re.MULTILINE)
    if count is not None:
        assert len(listed) == len(re.findall(r"<tr><t[hd][^>]*>t\d{3}<", page)) == count
        assert all(beside in line for line in listed)
    assert f"{out / 'import.html'}: look at what was found" in done.output
    assert cuts.exists() == bool(listed)
    if listed:
        found = yaml.safe_load(cuts.read_text())["cuts"]
        assert [cut["keep"] for cut in found] == ["auto"] * len(listed)
        if count == N:
            times = 1e-9 * np.array(session().contacts)
            assert [cut["contact_s"] for cut in found] == pytest.approx(times.tolist(), abs=1 / RATE)


@pytest.mark.parametrize(
    "changes, mend",
    [
        ({"force_n": lambda f: -f}, ("--force=-1*force_n",)),
        ({"velocity_m_per_s": lambda v: -1000.0 * v}, ("--velocity=-0.001*velocity_m_per_s",)),
    ],
)
def test_the_cuts_of_a_refusal_decide_nothing(tmp_path, changes, mend):
    """Once the remedy is followed the same command with the same cuts gives what it would have without."""
    path, out, cuts = log(tmp_path, **changes), tmp_path / "out", tmp_path / "cuts.yaml"
    assert isinstance(run(path, "--out", out, "--review", cuts).exception, InputError)
    text = cuts.read_text()
    done = run(path, "--out", out, "--review", cuts, *mend)
    assert done.exit_code == 0 and f"{N} kept" in done.output, done.output
    assert cuts.read_text() == text
    assert run(path, "--out", tmp_path / "anew", *mend).exit_code == 0
    for name in ("trials.csv", "traces/t003.csv"):
        assert (out / name).read_bytes() == (tmp_path / "anew" / name).read_bytes()


def test_a_recording_of_that_name_that_is_another(tmp_path):
    """Contacts of which nothing was decided are those that are found, however the times have moved."""
    cuts = tmp_path / "cuts.yaml"
    path = log(tmp_path, force_n=lambda f: -f)
    assert isinstance(run(path, "--out", tmp_path / "out", "--review", cuts).exception, InputError)
    later = {name: np.r_[column[:60], column] for name, column in columns(session()).items()}
    later["time_s"] = np.arange(later["time_s"].size) / RATE
    np.savez(path, **later)
    done = run(path, "--out", tmp_path / "out", "--review", cuts, "--json")
    times = 1e-9 * np.array(session().contacts) + 60 / RATE
    found = [cut["contact_s"] for cut in json.loads(done.output)["cuts"]]
    assert found == pytest.approx(times.tolist(), abs=1 / RATE)


def test_an_earlier_data_set_stays(tmp_path):
    """With its page; that of the refusal lies beside it until the next good import."""
    rig, out = tmp_path / "rig.yaml", tmp_path / "out"
    rig.write_text(RIG)
    assert run(log(tmp_path), "--out", out, "--rig", rig).exit_code == 0
    before = read_folder(out)
    done = run(log(tmp_path), "--out", out, "--force", "-1*force_n")
    assert isinstance(done.exception, InputError)
    after = read_folder(out)
    assert b"Why no data set came of it" in after.pop("import_refused.html") and after == before
    assert f"{out / 'import_refused.html'}: look at what was found" in done.output
    assert run(log(tmp_path), "--out", out).exit_code == 0
    assert read_folder(out).keys() == before.keys()


def test_contacts_beyond_what_a_data_set_holds_are_dropped(tmp_path):
    """Two speeds of 5 m/s, one pretension of 6 kN: told and listed; a user who keeps them is told where."""
    times = session().seconds

    def fast(v):
        there = (times > 1e-9 * session().contacts[2] - 0.2) & (times < 1e-9 * session().contacts[3] + 0.02)
        return np.where(there & (v > 0.03), v + 5.2, v)

    def pressed(p):
        return np.where(np.abs(times - 1e-9 * session().contacts[6] + 0.1) < 0.15, 6000.0, p)

    path = log(tmp_path, velocity_m_per_s=fast, pretension_n=pressed)
    (tmp_path / "rig.yaml").write_text(RIG)
    cuts, out = tmp_path / "cuts.yaml", tmp_path / "out"
    done = run(path, "--out", out, "--rig", tmp_path / "rig.yaml", "--review", cuts)
    assert done.exit_code == 0 and "8 contacts in 3.5 s, 5 kept" in done.output, done.output
    assert re.search(r"t002 is not kept: the velocity of 5.4 m/s is beyond 5 m/s", done.output)
    assert "t006 is not kept" in done.output and "the pretension of 6000 N is beyond 5000 N" in done.output
    assert len(read_dataset(out).trials) == 5
    cuts.write_text(cuts.read_text().replace("keep: false", "keep: true"))
    said = run(path, "--out", tmp_path / "new", "--rig", tmp_path / "rig.yaml", "--review", cuts).exception
    assert [fault.split(";")[0] for fault in said.faults] == [
        f"{cuts} trial 't002': the robot moves at 5.4 m/s there, beyond 5 m/s",
        f"{cuts} trial 't003': the robot moves at 5.4 m/s there, beyond 5 m/s",
        f"{cuts} trial 't006': the pretension is 6000 N there, beyond 5000 N",
    ]
    assert not (tmp_path / "new/trials.csv").exists() and (tmp_path / "new/import.html").exists()


def test_faults_of_the_data_set_name_contacts(tmp_path, monkeypatch):
    """Not rows and files that were never written."""

    def wrong(folder):
        faults = [
            "trials.csv row 4 (trial 't002'): is odd",
            "traces/t003.csv: is odd",
            "traces/t003.csv row 9: is odd",
        ]
        raise InputError([f"{folder}/{fault}" for fault in faults] + ["dataset.yaml: rig: is odd"])

    monkeypatch.setattr("acf_jax.recording.write.read_dataset", wrong)
    (tmp_path / "rig.yaml").write_text(RIG)
    out = tmp_path / "out"
    done = run(
        log(tmp_path), "--out", out, "--rig", tmp_path / "rig.yaml", "--review", tmp_path / "cuts.yaml"
    )
    times = [1e-9 * contact for contact in session().contacts]
    found = re.findall(r"^contact at (\S+) s \(trial '(t\d+)'\): is odd$", str(done.exception), re.MULTILINE)
    assert [name for _, name in found] == ["t002", "t003"]  # equal faults are told once
    assert [float(at) for at, _ in found] == pytest.approx([times[2], times[3]], abs=1 / RATE)
    assert done.exception.faults[2] == "dataset.yaml: rig: is odd"
    assert [file.name for file in out.iterdir()] == ["import.html"] and (tmp_path / "cuts.yaml").exists()


def test_json_holds_what_was_found(tmp_path):
    done = run(log(tmp_path), "--out", tmp_path / "out", "--force=-1*force_n", "--json")
    document = json.loads(done.output[: done.output.rindex("}") + 1])
    assert document["faults"] == done.exception.faults and len(document["cuts"]) == N


def test_a_page_that_cannot_be_written_hides_no_reason(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out/import.html").mkdir()
    done = run(log(tmp_path), "--out", tmp_path / "out", "--force=-1*force_n")
    first, second = done.exception.faults
    assert "negative in contact" in first and "import.html: cannot be written" in second


def test_a_decision_is_true_false_or_auto(tmp_path):
    cuts = tmp_path / "cuts.yaml"
    lines = [
        f"- {{trial: {name}, contact_s: 0.3, keep: {keep}}}"
        for name, keep in zip("abc", ("maybe", "", "auto"), strict=True)
    ]
    cuts.write_text("schema: acf-import-cuts/1\nrecording: log.npz\ncuts:\n" + "\n".join(lines))
    faults = run(log(tmp_path), "--out", tmp_path / "out", "--review", cuts).exception.faults
    assert faults == [
        f"{cuts}: cuts.0.keep: is 'maybe'; write true, false or auto",
        f"{cuts}: cuts.1.keep: is empty; write true, false or auto",
    ]

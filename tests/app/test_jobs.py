"""Jobs: one at a time, with a state that outlives pages, tabs and the server."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from acf_jax.app import jobs
from acf_jax.app.pages.provisional import known_so_far
from acf_jax.app.stages import DIAGNOSE, left_after
from acf_jax.errors import InputError

RIG = Path(__file__).resolve().parents[2] / "examples/rig"


@pytest.fixture
def session(tmp_path: Path) -> Path:
    return tmp_path


def until(session: Path, *states: str) -> jobs.Job:
    """The job once it is in one of the states."""
    end = time.monotonic() + 60
    while time.monotonic() < end:
        job = jobs.last(session)
        if job is not None and job.state in states:
            return job
        time.sleep(0.01)
    raise AssertionError(f"is {job and job.state}, not {states}")


@pytest.fixture
def diagnosis(session: Path) -> Iterator[jobs.Job]:
    """A diagnosis that has told a stage; it would take half a minute."""
    shutil.copytree(RIG, session / "data")
    jobs.start(session, "diagnose", ["diagnose", "data", "--out", "diagnosis"])
    end = time.monotonic() + 120
    while not (job := until(session, "running")).stages:
        assert time.monotonic() < end
        time.sleep(0.01)
    yield job
    jobs.cancel(session)
    until(session, "stopped", "interrupted", "done")


def pid_of(session: Path) -> int:
    pid: int = json.loads((session / ".app/diagnose/job.json").read_text())["pid"]
    return pid


def test_a_command_ends_with_its_code_output_and_messages(session: Path) -> None:
    jobs.start(session, "plan", ["peak", "--m", "4", "--d", "0", "--k-f", "0", "--k-c", "175561", "--v-e", "0.2",
                                 "--f-p", "100", "--json"])  # fmt: skip
    job = until(session, "done")
    assert json.loads(job.output.read_text())["peaks"][0]["f_max"] == pytest.approx(195.17, abs=0.01)
    jobs.start(session, "diagnose", ["diagnose", "none", "--out", "out"])
    job = until(session, "failed")
    assert (
        any("none" in line and "error:" in line for line in job.messages) and not (session / "out").exists()
    )
    assert jobs.job(session, "plan").state == "done"  # type: ignore[union-attr]


def test_a_session_has_one_job_at_a_time_and_cancelling_leaves_nothing(
    session: Path, diagnosis: jobs.Job
) -> None:
    with pytest.raises(InputError, match="runs in this session already"):
        jobs.start(session, "import", ["import", "x", "--out", "data"])
    with pytest.raises(InputError, match="runs in this session already"):
        jobs.start(session, "import", lambda: pytest.fail("something is written though nothing is started"))
    # a page that is loaded again, or a server that was started anew, sees the same: all of it is on the disk
    seen = "from pathlib import Path; from acf_jax.app import jobs; print(jobs.last(Path('.')).state)"
    command = [sys.executable, "-c", seen]
    assert subprocess.run(command, cwd=session, capture_output=True, text=True).stdout.strip() == "running"
    jobs.cancel(session)
    job = until(session, "stopped", "interrupted")
    assert not (session / "diagnosis").exists()
    assert {path.name for path in session.glob(".diagnosis*")} <= {
        ".diagnosis.unfinished"
    }  # fits, to go on with
    assert job.stages[0][0] == "looking at the data"


def test_a_job_that_was_killed_is_told_and_can_begin_again(session: Path, diagnosis: jobs.Job) -> None:
    os.kill(pid_of(session), signal.SIGKILL)
    job = until(session, "interrupted")
    assert not job.is_running and job.command == ("diagnose", "data", "--out", "diagnosis")
    jobs.start(session, "diagnose", ["peak", "--help"])
    assert until(session, "done").stages == ()


def test_progress_tells_the_time_that_is_left(session: Path, diagnosis: jobs.Job) -> None:
    told = diagnosis.document()
    assert told["state"] == "running" and told["stages"][0] == "looking at the data"
    assert 0.0 < told["left"] < 600.0 and told["elapsed"] > 0.0


def test_a_state_on_the_disk_that_is_damaged_is_no_job(session: Path) -> None:
    (session / ".app/import").mkdir(parents=True)
    for text in ("", "[]", "{}", '{"kind": "rm -rf"}', '{"kind": 3}', "\x00", '{"kind": "import"}'):
        (session / ".app/job.json").write_text(text)
        assert jobs.last(session) is None
        jobs.cancel(session)
    (session / ".app/import/job.json").write_text(
        '{"kind": "import", "started": 1.0, "command": ["x"], "pid": 1}'
    )
    assert jobs.last(session).state == "interrupted"  # type: ignore[union-attr]
    for text in (
        '{"kind": "import", "started": "x", "command": []}',
        '{"kind": "import", "started": 1.0, "command": 3}',
    ):
        (session / ".app/plan").mkdir(exist_ok=True)
        (session / ".app/plan/job.json").write_text(text)
        assert jobs.job(session, "plan") is None
    jobs.cancel(session)  # asks nobody to stop: no process holds the lock
    (session / ".app/import/progress.txt").write_bytes(b'\xff{"stage"\n{"stage": 1}\nerror: a <b>\n')
    (session / ".app/import/code.txt").write_text("2\n")
    job = jobs.last(session)
    assert job is not None and job.state == "failed" and job.messages[-1] == "error: a <b>"


def test_a_fault_that_no_command_foresaw_is_told_in_one_line(session: Path) -> None:
    (session / ".app/plan").mkdir(parents=True)
    (session / ".app/plan/job.json").write_text('{"kind": "plan", "started": 1.0, "command": []}')
    (session / ".app/plan/code.txt").write_text("1\n")
    lines = ["note: before", jobs.TRACEBACK, '  File "x.py", line 1', "    x", "ValueError: of what", ""]
    (session / ".app/plan/progress.txt").write_text("\n".join(lines))
    job = jobs.job(session, "plan")
    assert job is not None and len(job.messages) == 2 and job.messages[0] == "note: before"
    assert job.messages[1].startswith("error: ValueError: of what: ") and "report" in job.messages[1]


def test_what_a_command_knows_is_read_line_by_line(session: Path) -> None:
    (session / ".app/plan").mkdir(parents=True)
    (session / ".app/plan/job.json").write_text('{"kind": "plan", "started": 1.0, "command": []}')
    lines = ['{"known": {"trust": 1}}', '{"known": 3}', "{known", '{"stage": "a", "done": 0, "total": 0, "at": 2.0}',
             '{"known": {"gap": 2}}', "note: it goes on"]  # fmt: skip
    (session / ".app/plan/progress.txt").write_text("\n".join(lines))
    job = jobs.job(session, "plan")
    assert job is not None and job.known == ({"trust": 1}, {"gap": 2}) and job.document()["known"] == 2
    assert [name for name, _ in job.stages] == ["a"] and job.messages[-1] == "note: it goes on"


def test_what_is_known_so_far_may_be_damaged_or_foreign() -> None:
    trust = {"trust": {"headline": "<b>Data</b>", "limits": ["a < b"]}}
    evidence = [{"effects": [], "value": 0.0}, {"effects": ["end_stop"], "value": 1234.56}]
    found = known_so_far([trust, {"log_evidence": evidence[:1]}, {"log_evidence": evidence}])
    assert (
        "&lt;b&gt;Data" in found
        and "A &lt; b." in found
        and "+1,234.6" in found
        and "2 explanations" in found
    )
    for wrong in (
        {"trust": 3},
        {"gap": {}},
        {"log_evidence": [{"effects": ["<i>"], "value": 1}]},
        {"other": 1},
        {},
    ):
        assert known_so_far([wrong]) == ""


def test_time_left_follows_the_pace_of_this_machine() -> None:
    names = list(DIAGNOSE)
    whole = sum(DIAGNOSE.values())
    slow = 3.0  # times as long as where the shares were measured
    begun = [sum(DIAGNOSE[n] for n in names[:i]) * slow for i in range(len(names))]
    for i in range(3, len(names)):
        stages = list(zip(names[: i + 1], begun, strict=False))
        left = left_after("diagnose", stages, begun[i], 0, 0)
        assert left == pytest.approx(slow * whole - begun[i])
    assert left_after("diagnose", [("another", 0.0)], 1.0, 0, 0) is None
    assert left_after("import", [("reading", 1.0)], 3.0, 25, 100) == pytest.approx(6.0)
    assert left_after("import", [("reading", 1.0)], 3.0, 0, 0) is None
    assert left_after("import", [], 3.0, 0, 0) is None

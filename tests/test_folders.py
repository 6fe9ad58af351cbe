"""A run into a folder that holds another: all new or all old, whenever it stops, and what is the user's stays."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from acf_jax.folders import read_folder, recover, whole_folder
from tests.killed import AT_A_RENAME

MINE = {"notes.txt": b"mine", "traces/mine.csv": b"mine"}
OLD = {"report.html": b"old", "traces/t000.csv": b"old", "traces/t001.csv": b"old"}
NEW = {"added.json": b"new", "report.html": b"new", "traces/t000.csv": b"new"}
MOVES = 7  # this run is whole; three files of the earlier one aside, three of this one into their places


def test_a_link_to_another_file_system(tmp_path: Path) -> None:
    """Renames stay within the folder that is there: what is beside it may lie elsewhere."""
    there, link = tmp_path / "there", tmp_path / "links" / "out"
    there.mkdir()
    link.parent.mkdir()
    link.symlink_to(there)
    with whole_folder(link) as scratch:
        assert scratch.resolve().is_relative_to(there)
        (scratch / "a").write_text("new")
    assert read_folder(there) == {"a": b"new"} and [p.name for p in link.parent.iterdir()] == ["out"]


def write(folder: Path) -> None:
    with whole_folder(folder, ["traces/t001.csv", "traces/none.csv"]) as scratch:
        for name, content in NEW.items():
            (scratch / name).parent.mkdir(exist_ok=True)
            (scratch / name).write_bytes(content)


def stopped(monkeypatch: pytest.MonkeyPatch, folder: Path, at: int, how) -> None:  # type: ignore[no-untyped-def]
    """Write into a folder of an earlier run; `how` happens before the move `at`."""
    for name, content in (MINE | OLD).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    rename, moves = os.replace, []

    def replace(source: Path, destination: Path) -> None:
        moves.append(source)
        if len(moves) == at:
            how()
        rename(source, destination)

    with monkeypatch.context() as patch:
        patch.setattr("os.replace", replace)
        write(folder)
    assert len(moves) == MOVES


def full() -> None:
    raise OSError("no space left")


@pytest.mark.parametrize("at", range(1, MOVES + 1))
def test_a_fault_at_any_move_leaves_the_old_files(at, monkeypatch, tmp_path):
    with pytest.raises(OSError, match="no space left"):
        stopped(monkeypatch, tmp_path / "out", at, full)
    assert read_folder(tmp_path) == {f"out/{name}": content for name, content in (MINE | OLD).items()}


@pytest.mark.parametrize("at", range(1, MOVES + 1))
def test_ctrl_c_at_any_move_leaves_the_new_files(at, monkeypatch, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        stopped(monkeypatch, tmp_path / "out", at, lambda: signal.raise_signal(signal.SIGINT))
    assert read_folder(tmp_path) == {f"out/{name}": content for name, content in (MINE | NEW).items()}


def put(folder: Path, files: dict[str, bytes]) -> None:
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)


KILLED = (
    AT_A_RENAME
    + """
sys.path.insert(0, "tests")
from pathlib import Path
from test_folders import write
write(Path(sys.argv[1]))
"""
)


@pytest.mark.parametrize("at", range(1, MOVES + 2))
def test_a_kill_at_any_move_is_recovered(at, tmp_path):
    """Before the first move nothing has changed; from then on the run that was killed is completed."""
    out = tmp_path / "out"
    put(out, MINE | OLD)
    root = Path(__file__).parents[1]
    done = subprocess.run([sys.executable, "-c", KILLED, str(at), str(out)], cwd=root, check=False)
    assert done.returncode == (-signal.SIGKILL if at <= MOVES else 0)
    recover(out)
    assert read_folder(tmp_path) == {
        f"out/{name}": content for name, content in (MINE | (OLD if at == 1 else NEW)).items()
    }


def test_a_run_that_lives_is_left_alone(tmp_path):
    """Its scratch folder is not removed by another run into the same folder; nor are a user's hidden folders."""
    out = tmp_path / "out"
    put(out, OLD)
    put(tmp_path, {".out.backup/new/a": b"mine"})
    with whole_folder(out) as first:
        (first / "report.html").write_text("first")
        with whole_folder(out) as second:
            (second / "added.json").write_text("second")
    assert read_folder(out) == OLD | {"report.html": b"first", "added.json": b"second"}
    assert read_folder(tmp_path / ".out.backup") == {"new/a": b"mine"}


def test_recovery_stays_in_its_folder(tmp_path):
    """Whatever a scratch folder that came with somebody's data says."""
    put(tmp_path, {"kept": b"mine", "elsewhere/kept": b"mine"})
    out = tmp_path / "out"
    put(out / ".out.x", {"acf-jax.lock": b"", "whole/link/kept": b"theirs", "whole/a": b"theirs"})
    names = ["../kept", str(tmp_path / "kept"), 3]
    for stale in (json.dumps(names[:2]), json.dumps(names), "{"):
        (out / ".out.x/stale.json").write_text(stale)
        (out / "link").symlink_to(tmp_path / "elsewhere")
        recover(out)
        assert (out / "a").read_bytes() == b"theirs" and not (out / ".out.x").exists()
        (out / "link").unlink()
        put(out / ".out.x", {"acf-jax.lock": b"", "whole/link/kept": b"theirs", "whole/a": b"theirs"})
    assert (tmp_path / "kept").read_bytes() == (tmp_path / "elsewhere/kept").read_bytes() == b"mine"

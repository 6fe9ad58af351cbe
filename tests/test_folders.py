"""A run into a folder that holds another: all new or all old, whenever it stops, and what is the user's stays."""

import os
import signal
from pathlib import Path

import pytest

from acf_jax.folders import read_folder, whole_folder

MINE = {"notes.txt": b"mine", "traces/mine.csv": b"mine"}
OLD = {"report.html": b"old", "traces/t000.csv": b"old", "traces/t001.csv": b"old"}
NEW = {"added.json": b"new", "report.html": b"new", "traces/t000.csv": b"new"}
MOVES = 6  # three files of the earlier run aside, three of this one into their places


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

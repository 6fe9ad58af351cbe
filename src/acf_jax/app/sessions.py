"""A session: one folder with the files that the commands read and write, and nothing that only the app knows.

session.yaml   which recording, and where it lies
recording/     what was uploaded; absent where a recording is opened in place
mapping.yaml   its signals                  `import --mapping`
cuts.yaml      decisions about its contacts `import --review`; absent where nothing is decided
rig.yaml       what is known of the rig     `import --rig`
data/          the data set                 `diagnose`
diagnosis/     what was found               `predict`, `speed`, `design`, `check`, `train`
plan/          trials that are planned      `plan`
surrogate/     a trained surrogate          `export`
design.yaml    the last question for the best setting   `design --config`
.app/          jobs: their progress, output and exit code; what was asked
"""

import fcntl
import hashlib
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pydantic import Field

from acf_jax.app.jobs import FOLDER
from acf_jax.app.security import Places
from acf_jax.documents import yaml_text
from acf_jax.errors import InputError, shown
from acf_jax.files import inside, read_yaml_mapping, write_text
from acf_jax.folders import write_folder
from acf_jax.forms import Part, check_form

ABOUT, MAPPING, CUTS, RIG = "session.yaml", "mapping.yaml", "cuts.yaml", "rig.yaml"
DATA, DIAGNOSIS, PLAN, SURROGATE, UPLOADED = "data", "diagnosis", "plan", "surrogate", "recording"
DESIGN = "design.yaml"
NAME = re.compile(r"[^\W_][\w.+ -]{0,79}")
UNFINISHED = f".{DIAGNOSIS}.unfinished"  # fits of a diagnosis that was interrupted
PARTS = (FOLDER, ABOUT, UPLOADED, MAPPING, CUTS, RIG, DATA, DIAGNOSIS, UNFINISHED, PLAN, SURROGATE, DESIGN)
NEW = "none"  # version of a file that is not there


class About(Part):
    """session.yaml."""

    schema_: Literal["acf-session/1"] = Field(default="acf-session/1", alias="schema")
    recording: str | None = (
        None  # path from the session's folder, or an absolute one of a recording opened in place
    )
    robot: str | None = None  # the same of the recording of the robot's signals


class Changed(InputError):
    """A file is another one than the page that writes it has shown."""


@dataclass(frozen=True)
class Session:
    """One folder, and how addresses name it."""

    place: int
    name: str
    folder: Path
    places: Places

    @property
    def url(self) -> str:
        """Of its pages."""
        return f"/s/{self.place}/{self.name}"

    @property
    def about(self) -> About:
        """`InputError` where session.yaml is damaged."""
        path = self.folder / ABOUT
        return check_form(About, read_yaml_mapping(path), path) if path.exists() else About()

    def recording(self, which: Literal["recording", "robot"] = "recording") -> Path | None:
        """The path from the session's folder or an absolute one; `InputError` where it leaves the chosen folders."""
        name = getattr(self.about, which)
        if name is None:
            return None
        if name.startswith("-"):
            raise InputError(
                f"{self.folder / ABOUT}: {which}: {shown(name)} begins with a dash; rename the file"
            )
        self.places.check(self.folder / name)
        return Path(name)

    def has(self, *parts: str) -> bool:
        """Whether a file is there."""
        return self.folder.joinpath(*parts).is_file()

    @property
    def is_imported(self) -> bool:
        return self.has(DATA, "trials.csv")

    @property
    def is_diagnosed(self) -> bool:
        return self.has(DIAGNOSIS, "diagnosis.json") and self.has(DIAGNOSIS, "model.json")

    @property
    def has_rig(self) -> bool:
        """Whether the rig is described: in rig.yaml, or in a data set whose template is filled in."""
        from acf_jax.recording.rig import earlier_rig

        if self.has(RIG):
            return True
        try:
            return (
                self.has(DATA, "dataset.yaml")
                and earlier_rig(self.folder / DATA / "dataset.yaml") is not None
            )
        except InputError:
            return False  # the form begins anew

    def version(self, name: str) -> str:
        """What tells one content of a file from another."""
        path = self.folder / name
        return hashlib.sha256(path.read_bytes()).hexdigest()[:16] if path.is_file() else NEW

    @contextmanager
    def writing(self, name: str, seen: str) -> Iterator[None]:
        """Nobody else writes meanwhile; `Changed` unless the file is as the page has shown it, `seen`."""
        (self.folder / FOLDER).mkdir(exist_ok=True)
        with (self.folder / FOLDER / "writing").open("a") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if self.version(name) != seen:
                raise Changed(
                    f"{name}: was changed in another tab or by a command; nothing is written: load the page again"
                )
            yield

    def write(self, name: str, text: str, seen: str) -> None:
        """Write a file whole, unless it is no longer as the page has shown it."""
        with self.writing(name, seen):
            write_text(self.folder / name, text)

    def describe(self, about: About) -> None:
        """Write session.yaml."""
        write_text(self.folder / ABOUT, yaml_text(about.model_dump(by_alias=True, exclude_none=True)))


def is_session(folder: Path) -> bool:
    """Whether a folder holds what a session holds; a folder of `run` does."""
    return any(
        (folder / part).is_file() for part in (ABOUT, f"{DATA}/dataset.yaml", f"{DIAGNOSIS}/model.json")
    )


def find(places: Places, place: int, name: str) -> Session:
    """The session of that name; `InputError` where there is none, and where a link in it leads out of the folders."""
    if not NAME.fullmatch(name):
        raise InputError(f"session {shown(name)}: no such name; go back to all sessions")
    folder = places.resolve(place, name)
    if not folder.is_dir() or not is_session(folder):
        raise InputError(f"session {shown(name)}: is not in {places.folders[place]}; go back to all sessions")
    for part in PARTS:
        for path in _links(folder / part):
            places.check(path)  # it may have come with a folder of others
    return Session(place, name, folder, places)


def _links(part: Path) -> Iterator[Path]:
    """Every link of a file or folder, itself among them."""
    if part.is_symlink():
        yield part
    for here, folders, files in os.walk(part):
        names = (os.path.join(here, name) for name in (*folders, *files))
        yield from (Path(name) for name in names if os.path.islink(name))


def every(places: Places) -> list[Session]:
    """All sessions, those touched last first."""
    found = [
        Session(place, path.name, path, places)
        for place, folder in enumerate(places.folders)
        for path in (sorted(folder.iterdir()) if folder.is_dir() else ())
        if path.is_dir()
        and NAME.fullmatch(path.name)
        and path.resolve().is_relative_to(folder)
        and is_session(path)
    ]
    return sorted(found, key=lambda session: -session.folder.stat().st_mtime)


def create(places: Places, name: str) -> Session:
    """An empty session in the first folder; a number is added to a name that is taken."""
    stem = re.sub(r"[^\w.+ -]", "_", name).strip(" ._")[:60] or "session"
    if not NAME.fullmatch(stem):
        stem = f"session {stem}"
    for number in range(1, 1000):
        called = stem if number == 1 else f"{stem} {number}"
        folder = places.resolve(0, called)
        try:
            folder.mkdir()
        except FileExistsError:
            continue
        session = Session(0, called, folder, places)
        session.describe(About())
        return session
    raise InputError(f"{stem}: a thousand sessions are called so; choose another name")


def open_in_place(session: Session, path: Path) -> None:
    """Take a recording that lies elsewhere in the chosen folders, or the data set in a folder."""
    path = session.places.check(path)
    if (path / "dataset.yaml").is_file():
        copy_data_set(path, session.folder / DATA)
        return
    session.describe(session.about.model_copy(update={"recording": str(path)}))


def copy_data_set(source: Path, target: Path) -> None:
    """Copy a data set's description, table and the files that the table names; `InputError` lists its faults."""
    from acf_jax.dataset import read_dataset
    from acf_jax.dataset.table import read_table

    read_dataset(source)
    names = {"dataset.yaml", "trials.csv"}
    for row in read_table(source / "trials.csv", ("trial",)).rows:
        names |= {cell for key in ("trace", "motion") if (cell := row.cells.get(key))}
    write_folder(target, {name: inside(source, name).read_bytes() for name in names})


def remove(session: Session) -> None:
    """Delete what the app put there; a folder that holds other files keeps them."""
    shutil.rmtree(session.folder)

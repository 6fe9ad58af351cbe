"""Step 7, Fleet: the diagnoses of several sessions as `fleet` writes them, so that its --since reads them, too."""

import json
import time
from collections.abc import Sequence
from pathlib import Path

from acf_jax.app.sessions import DATA, DIAGNOSIS, Session
from acf_jax.errors import InputError
from acf_jax.files import read_json_mapping, write_text
from acf_jax.folders import write_folder
from acf_jax.provenance import Origin

FOLDER = "fleets"  # in the first chosen folder
WRITTEN = ("diagnosis.json", "model.json", "report.html")


def earlier(home: Path) -> list[str]:
    """Names of the comparisons that are there, oldest first."""
    from acf_jax.fleet.record import read_fleet

    found = []
    for path in sorted((home / FOLDER).glob("*/fleet.json")):
        try:
            found.append((read_fleet(path.parent).finished, path.parent.name))
        except InputError:
            continue
    return [name for _, name in sorted(found)]


def reports(home: Path, label: str) -> list[str]:
    """Names of the rigs of a comparison whose reports are there."""
    return sorted(path.parent.name for path in (home / FOLDER / label).glob("*/report.html"))


def compare(home: Path, sessions: Sequence[Session], since: Sequence[str]) -> str:
    """Write a comparison of diagnosed sessions; its name.

    **Arguments:** `home`: folder that holds them. `since`: names of earlier ones to compare with.

    **Raises:** `InputError` for no session, sessions of one name, and a diagnosis that is damaged.
    """
    from acf_jax.dataset import read_dataset
    from acf_jax.fleet.changes import find_changes
    from acf_jax.fleet.page import fleet_page
    from acf_jax.fleet.record import FILE, Fleet, Rig, read_fleets, rig_of

    if not sessions:
        raise InputError("no session is chosen; choose one at least")
    names = [session.name for session in sessions]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise InputError(f"{twice}: is chosen twice; choose one session of a name")
    known = earlier(home)
    if strange := [name for name in since if name not in known]:
        raise InputError(f"{strange[0]}: is no earlier comparison; choose one of the list")
    runs = read_fleets([home / FOLDER / name for name in known if name in since])
    label = _label(home)
    rigs: list[Rig] = []
    for session in sessions:
        path = session.folder / DIAGNOSIS / "diagnosis.json"
        content = read_json_mapping(path, "diagnose again")
        try:
            digest = read_dataset(session.folder / DATA).digest
        except InputError:
            digest = session.version(f"{DIAGNOSIS}/diagnosis.json")  # of a folder without its data
        try:
            rigs.append(rig_of(session.name, digest, content))
        except (AttributeError, LookupError, TypeError, ValueError):
            raise InputError(f"{path}: is damaged; diagnose again") from None
    fleet = Fleet(label=label, finished=time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime()), rigs=tuple(rigs))
    changes, trends = find_changes([*runs, fleet])
    missing = tuple(rig.rig for run in runs[-1:] for rig in run.rigs if rig.rig not in names)
    compared = {"since": tuple(run.label for run in runs), "missing": missing, "changes": tuple(changes)}
    fleet = fleet.model_copy(update=compared)
    out = home / FOLDER / label
    for session in sessions:
        made = session.folder / DIAGNOSIS
        write_folder(
            out / session.name, {n: (made / n).read_bytes() for n in WRITTEN if (made / n).is_file()}
        )
    origin = Origin("acf-jax app, a comparison", {rig.rig: rig.data for rig in rigs})
    write_text(out / "index.html", fleet_page(fleet, trends, str(origin)))
    origin.write(out)
    write_text(out / FILE, json.dumps(fleet.model_dump(mode="json", by_alias=True), indent=1) + "\n")
    return label


def _label(home: Path) -> str:
    """A name that sorts by time and is not taken."""
    stem = time.strftime("%Y-%m-%d %H.%M.%S", time.localtime())
    names = (stem if n == 1 else f"{stem} {n}" for n in range(1, 1000))
    return next(name for name in names if not (home / FOLDER / name).exists())

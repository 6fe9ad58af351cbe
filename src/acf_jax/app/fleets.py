"""Step 7, Fleet: the diagnoses of several sessions as `fleet` writes them, so that its --since reads them, too."""

import time
from collections.abc import Sequence
from pathlib import Path

from acf_jax.app.sessions import DIAGNOSIS, Session
from acf_jax.errors import InputError
from acf_jax.files import read_json_mapping
from acf_jax.folders import write_folder
from acf_jax.provenance import Origin

FOLDER = "fleets"  # in the first chosen folder


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
    from acf_jax.fleet.record import Rig, read_fleets, rig_of
    from acf_jax.fleet.results import new_fleet, write_fleet
    from acf_jax.fleet.run import WRITTEN

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
        # of the data that were diagnosed, which the session may not hold any more; an earlier version names none
        digest = content.get("data_sha256") or session.version(f"{DIAGNOSIS}/diagnosis.json")
        try:
            rigs.append(rig_of(session.name, digest, content))
        except (AttributeError, LookupError, TypeError, ValueError):
            raise InputError(f"{path}: is damaged; diagnose again") from None
    out = home / FOLDER / label
    for session in sessions:
        made = session.folder / DIAGNOSIS
        write_folder(
            out / session.name, {n: (made / n).read_bytes() for n in WRITTEN if (made / n).is_file()}
        )
    origin = Origin("acf-jax app, a comparison", {rig.rig: rig.data for rig in rigs})
    write_fleet(out, new_fleet(label, rigs), runs, origin)
    return label


def _label(home: Path) -> str:
    """A name that sorts by time and is not taken."""
    stem = time.strftime("%Y-%m-%d %H.%M.%S", time.localtime())
    names = (stem if n == 1 else f"{stem} {n}" for n in range(1, 1000))
    return next(name for name in names if not (home / FOLDER / name).exists())

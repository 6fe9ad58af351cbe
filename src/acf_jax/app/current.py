"""Whether results of a session belong together: by what they were made of, not by when they were written."""

import shlex
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

from acf_jax.app.sessions import DATA, DIAGNOSIS, Session
from acf_jax.errors import InputError
from acf_jax.files import read_json_mapping
from acf_jax.provenance import FILE


def is_outdated(session: Session) -> bool:
    """Whether the session's data set is another than the one that was diagnosed."""
    from acf_jax.dataset import read_dataset

    known = diagnosed(session)
    if not session.is_imported or not known:
        return False
    try:
        return read_dataset(session.folder / DATA).digest not in known
    except InputError:
        return True  # none was diagnosed that cannot be read


def diagnosed(session: Session) -> set[str]:
    """Digests of the data set behind the diagnosis: as it was read, and behind a low-pass where one was asked for."""
    folder = session.folder / DIAGNOSIS
    made_of = _json(folder / FILE).get("made_of")
    found = [_json(folder / "diagnosis.json").get("data_sha256")]
    found += (
        [part.get("sha256") for part in made_of if isinstance(part, dict)]
        if isinstance(made_of, list)
        else []
    )
    return {digest for digest in found if isinstance(digest, str)}


def diagnosed_by(session: Session) -> tuple[list[str], float | None]:
    """Effects and components that the diagnosis was told to leave out, and the cutoff of its low-pass, Hz."""
    from acf_jax.effects import COMPONENTS, library

    command = _json(session.folder / DIAGNOSIS / FILE).get("command")
    without, low_pass = [], None
    with suppress(ValueError):
        for option, value in pairwise(shlex.split(command if isinstance(command, str) else "")):
            if option == "--without" and value in (*library(), *COMPONENTS):
                without.append(value)
            if option == "--low-pass":
                low_pass = float(value)
    return without, low_pass


def surrogate_of(model: Path, learnt: Path) -> str | None:
    """The checksum of a surrogate that stands for a diagnosis' model.json; None where there is none that does."""
    from acf_jax.gap_model import check_model, read_model
    from acf_jax.surrogate.saved import read_header

    try:
        header = read_header(learnt)[0] if learnt.is_file() else {}
        # as models: one file leaves out what the other one writes as null
        is_same = check_model(learnt, header.get("model") or {}) == read_model(model)
    except InputError:
        return None
    checksum = header.get("sha256")
    return checksum if isinstance(checksum, str) and is_same else None


def is_made_of(path: Path, checksum: str | None) -> bool:
    """Whether a file that `export` wrote names the surrogate."""
    return checksum is not None and path.is_file() and checksum.encode() in path.read_bytes()


def _json(path: Path) -> dict[str, Any]:
    try:
        return read_json_mapping(path, "diagnose again")
    except InputError:
        return {}

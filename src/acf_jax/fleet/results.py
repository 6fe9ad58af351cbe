"""The results of a run over many rigs, compared with earlier ones, as files."""

import json
import time
from collections.abc import Sequence
from pathlib import Path

from acf_jax.files import write_text
from acf_jax.fleet.changes import find_changes
from acf_jax.fleet.page import fleet_page
from acf_jax.fleet.record import FILE, Fleet, Rig
from acf_jax.provenance import Origin

PAGE = "index.html"


def new_fleet(label: str, rigs: Sequence[Rig]) -> Fleet:
    """The record of a run that ends now."""
    finished = time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime())
    return Fleet(label=label, finished=finished, rigs=tuple(rigs))


def write_fleet(out: Path, fleet: Fleet, earlier: Sequence[Fleet], origin: Origin) -> Fleet:
    """Write the page of a run, where it comes from, and last its record.

    **Arguments:** `earlier`: runs to compare with, oldest first.

    **Returns:** the record as it is written, with what changed since the earlier runs.
    """
    changes, trends = find_changes([*earlier, fleet])
    known = {rig.rig for rig in fleet.rigs}
    missing = tuple(rig.rig for run in earlier[-1:] for rig in run.rigs if rig.rig not in known)
    compared = {"since": tuple(run.label for run in earlier), "missing": missing, "changes": tuple(changes)}
    fleet = fleet.model_copy(update=compared)
    write_text(out / PAGE, fleet_page(fleet, trends, str(origin)))
    origin.write(out)
    write_text(out / FILE, json.dumps(fleet.model_dump(mode="json", by_alias=True), indent=1) + "\n")
    return fleet

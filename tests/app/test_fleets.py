"""Comparisons of sessions: what `fleet` reads by --since, and what changed."""

import json
import shutil
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest

from acf_jax.app import fleets
from acf_jax.app.pages.fleet import fleet
from acf_jax.app.security import Places
from acf_jax.app.sessions import Session, every
from acf_jax.errors import InputError
from acf_jax.fleet.record import read_fleet

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def diagnosed(home: Path, name: str, cause: str) -> None:
    """A session whose diagnosis names a cause, and rules out any other."""
    gap = {"force_rms_n": 5.0, "peak_rms_percent": 1.0, "peak_max_percent": 2.0}
    content: dict[str, Any] = {
        "verdict": "identified",
        "explanations": [{"effects": [cause], "probability": 0.99}],
        "credible_set": [[cause]],
        "where": {"component": {"actuator": 0.99, "contact": 0.01, "robot": 0.0, "sensor": 0.0}},
        "gap": {"recalibrated": gap, "corrected": gap | {"force_rms_n": 1.0}},
        "shrinkage": {"force": {"value": 0.8, "ci95": [0.7, 0.9]}, "peak": None},
        "parameters": {"moving_mass_kg": {"value": 2.0, "std": 0.1, "unit": "kg", "at_bound": False}},
        "warnings": [],
    }
    folder = home / name / "diagnosis"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "diagnosis.json").write_text(json.dumps(content))
    shutil.copy(EXAMPLES / "rig_model.json", folder / "model.json")
    (folder / "report.html").write_text("<p>report</p>")


def sessions(home: Path) -> list[Session]:
    return sorted(every(Places([home])), key=lambda session: session.name)


def test_a_cause_that_changed_is_found(tmp_path: Path) -> None:
    for name in ("north", "south"):
        diagnosed(tmp_path, name, "end_stop")
    first = fleets.compare(tmp_path, sessions(tmp_path), [])
    diagnosed(tmp_path, "south", "coulomb_friction")
    second = fleets.compare(tmp_path, sessions(tmp_path), [first])
    assert fleets.earlier(tmp_path) == [first, second] and first != second
    found = read_fleet(tmp_path / "fleets" / second)
    assert [(change.rig, change.what) for change in found.changes] == [("south", "cause")]
    assert found.since == (first,) and (tmp_path / "fleets" / second / "south/report.html").is_file()
    # the page links the reports, since the comparison's own frame may not
    shown = fleet(Places([tmp_path]), second).body.decode()
    assert (
        f'href="/fleet/{quote(second)}/south/report.html"' in shown and fleets.reports(tmp_path, "..") == []
    )
    # a rig that is left out is told as missing
    third = fleets.compare(tmp_path, sessions(tmp_path)[:1], [first, second])
    assert read_fleet(tmp_path / "fleets" / third).missing == ("south",)


def test_a_comparison_names_the_data_that_were_diagnosed(tmp_path: Path) -> None:
    diagnosed(tmp_path, "north", "end_stop")
    shutil.copytree(EXAMPLES / "rig", tmp_path / "north/data")  # as they are now
    path = tmp_path / "north/diagnosis/diagnosis.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"data_sha256": "as it was"}))
    label = fleets.compare(tmp_path, sessions(tmp_path), [])
    assert read_fleet(tmp_path / "fleets" / label).rigs[0].data == "as it was"


def test_what_cannot_be_compared_is_told_and_leaves_nothing(tmp_path: Path) -> None:
    diagnosed(tmp_path, "north", "end_stop")
    with pytest.raises(InputError, match="no session is chosen"):
        fleets.compare(tmp_path, [], [])
    with pytest.raises(InputError, match="no earlier comparison"):
        fleets.compare(tmp_path, sessions(tmp_path), ["../.."])
    (tmp_path / "north/diagnosis/diagnosis.json").write_text('{"verdict": "identified"}')
    with pytest.raises(InputError, match="damaged; diagnose again"):
        fleets.compare(tmp_path, sessions(tmp_path), [])
    with pytest.raises(InputError, match="is chosen twice"):
        diagnosed(tmp_path, "north", "end_stop")
        fleets.compare(tmp_path, sessions(tmp_path) * 2, [])
    assert not (tmp_path / "fleets").exists()

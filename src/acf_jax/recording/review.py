"""cuts.yaml: the contacts of a recording, for a user to accept, drop or move."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from acf_jax.dataset import units
from acf_jax.documents import yaml_text
from acf_jax.errors import InputError, shown
from acf_jax.files import read_yaml_mapping
from acf_jax.forms import Part, check_form
from acf_jax.recording.cut import Cut

SCHEMA = "acf-import-cuts/1"
AUTO = "auto"  # nothing is decided
HEAD = """\
# The contacts of {recording}, by the time since its first force sample.
# keep: false drops one; another contact_s moves it; a line less or more removes or adds one.
# keep: auto decides nothing: the contact that is found there is kept if the checks find nothing odd.
# This file decides at the next import with --review FILE.
"""


def _decision(value: Any) -> bool | None:
    if value != AUTO and not isinstance(value, bool):
        what = "empty" if value is None else shown(value)
        raise ValueError(f"is {what}; write true, false or {AUTO}")
    return None if value == AUTO else value


class Entry(Part):
    """One contact."""

    trial: str = Field(min_length=1, max_length=100, pattern=r"^[A-Za-z0-9_]([\w.+-]*\w)?$")
    contact_s: float = Field(ge=0, description="s, first contact since the first force sample")
    keep: Annotated[bool | None, BeforeValidator(_decision)] = Field(
        description="None: auto, as the checks find"
    )


class Review(Part):
    """The file."""

    schema_: Literal["acf-import-cuts/1"] = Field(alias="schema")
    recording: str
    cuts: tuple[Entry, ...]


def read_review(path: Path, recording: str, duration: float) -> Review:
    """The user's decisions; `InputError` lists every fault.

    **Arguments:** `recording`: name of the recording that they have to be about. `duration`: its length, s.
    """
    review = check_form(Review, read_yaml_mapping(path), path)
    faults = []
    if review.recording != recording:
        faults.append(
            f"{path}: recording: is {review.recording!r}, not {recording!r}; name the review of this recording"
        )
    names = [entry.trial for entry in review.cuts]
    for name in dict.fromkeys(name for name in names if names.count(name) > 1):
        faults.append(f"{path}: trial {name!r} is there twice; give each cut a name of its own")
    faults += [
        f"{path} trial {e.trial!r}: contact_s is {e.contact_s:g}, beyond the recording's {duration:.3f} s; correct it"
        for e in review.cuts
        if e.contact_s > duration
    ]
    if all(entry.keep is False for entry in review.cuts):
        faults.append(f"{path}: keeps no cut; set keep: true for at least three")
    if faults:
        raise InputError(faults)
    return review


def kept_faults(path: Path, kept: Sequence[Cut]) -> list[str]:
    """Why contacts that the user keeps are none for a data set: no robot approaches like that."""
    found = []
    for cut in kept:
        v_e = cut.velocity.value
        if v_e < units.VELOCITY.low:
            fault = f"the robot moves at {v_e:.4g} m/s there, not towards the part"
        elif v_e > units.VELOCITY.high:
            fault = f"the robot moves at {v_e:.4g} m/s there, beyond {units.VELOCITY.high:g} m/s"
        elif units.PRETENSION.fault(max(cut.pretension.value, 0.0)):
            fault = (
                f"the pretension is {cut.pretension.value:.4g} N there, beyond {units.PRETENSION.high:g} N"
            )
        else:
            continue
        found.append(f"{path} trial {cut.trial!r}: {fault}; correct contact_s, or set keep: false")
    return found


def review_text(recording: str, entries: list[tuple[Entry, str]]) -> str:
    """The file as text: one cut a line, with what was measured as a comment."""
    name = yaml_text(recording).splitlines()[0]
    lines = [
        HEAD.format(recording=" ".join(recording.split())),
        f"schema: {SCHEMA}",
        f"recording: {name}",
        "cuts:",
    ]
    for entry, comment in entries:
        keep = AUTO if entry.keep is None else str(entry.keep).lower()
        trial = yaml_text(entry.trial).splitlines()[0]
        lines.append(f"  - {{trial: {trial}, contact_s: {entry.contact_s:.9f}, keep: {keep}}}  # {comment}")
    return "\n".join([*lines, ""])

"""`fleet.json`: what the diagnoses of many rigs came to, in one line each."""

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, field_validator, model_validator

from acf_jax import __version__
from acf_jax.errors import InputError, shown
from acf_jax.evidence.posterior import CREDIBLE
from acf_jax.files import read_json_mapping
from acf_jax.forms import Part, check_form

SCHEMA: Literal["acf-gap-fleet/1"] = "acf-gap-fleet/1"
FILE = "fleet.json"
FAR = 1e60  # beyond any parameter in SI units, and its square is still a number


class Estimate(Part):
    """A parameter of the corrected model."""

    value: float
    std: float | None = Field(ge=0)
    unit: str
    at_bound: bool

    @field_validator("value", "std")
    @classmethod
    def _can_be_squared(cls, number: float | None) -> float | None:
        if number and not 1 / FAR < abs(number) < FAR:
            raise ValueError(f"must be 0, or between {1 / FAR:g} and {FAR:g} in size")
        return number


class Rig(Part):
    """One rig: its diagnosis, or why it has none."""

    rig: str  # the name of its folder
    fault: str = ""  # a line each
    data: str = ""  # a hash of what the diagnosis was made of
    verdict: str = ""
    first: tuple[str, ...] = ()  # the most probable explanation
    probability: float | None = None  # of it
    credible: tuple[tuple[str, ...], ...] = ()  # the explanations that these data leave standing
    component: str | None = None  # where a cause most probably acts; None where there may be none
    components: tuple[str, ...] = ()  # where these data leave it possible that one acts
    recalibrated_rms_n: float | None = None  # force error on held-out conditions, before the correction
    corrected_rms_n: float | None = None  # and after it
    peak_rms_percent: float | None = None  # peak error on held-out conditions, after it
    shrinkage: float | None = None  # of the force error; of the peak error where there are no traces
    parameters: dict[str, Estimate] = Field(default={})
    warnings: int = 0


class Change(Part):
    """What is different about a rig since an earlier run."""

    rig: str
    what: str  # "cause", or the parameter's name
    before: str
    after: str
    sigmas: float | None = None  # the trend over its standard deviation; None for a cause


class Fleet(Part):
    """One run over all rigs."""

    schema_: Literal["acf-gap-fleet/1"] = Field(default=SCHEMA, alias="schema")
    version: str = __version__
    label: str  # of the run, on axes
    finished: str  # UTC
    rigs: tuple[Rig, ...]
    since: tuple[str, ...] = ()  # labels of the earlier runs, oldest first
    missing: tuple[str, ...] = ()  # rigs of the last of them that are not there now
    changes: tuple[Change, ...] = ()

    @model_validator(mode="after")
    def _lists_a_rig_once(self) -> Self:
        if twice := [name for name, n in Counter(rig.rig for rig in self.rigs).items() if n > 1]:
            raise ValueError(f"rig {shown(twice[0])} is listed more than once")
        return self


def rig_of(name: str, data: str, content: dict[str, Any]) -> Rig:
    """The line of a rig from its `diagnosis.json`."""
    first, gap, shrinkage = content["explanations"][0], content["gap"], content["shrinkage"]
    component = content["where"]["component"]
    removed = shrinkage["force"] or shrinkage["peak"]
    return Rig(
        rig=name,
        data=data,
        verdict=content["verdict"],
        first=first["effects"],
        probability=first["probability"],
        credible=content["credible_set"],
        component=max(component, key=component.__getitem__) if first["effects"] else None,
        components=tuple(name for name, p in component.items() if p >= 1 - CREDIBLE),
        recalibrated_rms_n=gap["recalibrated"]["force_rms_n"],
        corrected_rms_n=gap["corrected"]["force_rms_n"],
        peak_rms_percent=gap["corrected"]["peak_rms_percent"],
        shrinkage=removed and removed["value"],
        parameters={
            parameter: Estimate(**{key: value[key] for key in Estimate.model_fields})
            for parameter, value in content["parameters"].items()
        },
        warnings=len(content["warnings"]),
    )


def read_fleet(folder: Path) -> Fleet:
    """The record in a folder that `fleet` wrote; `InputError` says what is wrong with it."""
    path, remedy = folder / FILE, "name a folder that `fleet` wrote"
    return check_form(Fleet, read_json_mapping(path, remedy), path, remedy)


def read_fleets(folders: Sequence[Path]) -> list[Fleet]:
    """The records of earlier runs, which must be in the order in which they ended."""
    runs = [read_fleet(folder) for folder in folders]
    disorder = [
        f"{folder / FILE}: ended {run.finished}, but {last.label}, named before it, {last.finished}; name the oldest"
        " first. Where an older one was made again, run the later ones again too: nothing is diagnosed twice"
        for (_, last), (folder, run) in pairwise(zip(folders, runs, strict=True))
        if run.finished < last.finished
    ]
    if disorder:
        raise InputError(disorder)
    return runs

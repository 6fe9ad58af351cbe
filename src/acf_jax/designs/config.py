"""The question of a design, design.yaml: one frozen model, every fault at once."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from acf_jax.contact.ending import Ending, ending_faults
from acf_jax.dataset.units import unit_fault
from acf_jax.errors import InputError, shown
from acf_jax.files import read_yaml_mapping
from acf_jax.forms import Part, check_form

Goal = Literal["fastest", "highest_process_force", "widest_margin"]
IMPACT = ("v_e", "f_p")
POSITIVE = ("m", "k_c")
Span = tuple[float, float]  # lowest and highest value
COORDINATE: dict[str, str | None] = {"fastest": "v_e", "highest_process_force": "f_p", "widest_margin": None}


def _is_a_share(value: float) -> float:
    if not 0 <= value <= 0.5:
        raise ValueError(f"must lie between 0 and 0.5, but is {value:g}; give a share of the value")
    return value


Share = Annotated[float, AfterValidator(_is_a_share)]


class Range(Part):
    """What a free quantity may be."""

    low: float = Field(ge=0)
    high: float = Field(ge=0)

    @model_validator(mode="after")
    def _is_possible(self) -> Self:
        if self.low >= self.high:
            raise ValueError(
                f"low ({self.low:g}) must be below high ({self.high:g}); swap them, or give one number"
            )
        return self


class End(Part):
    """How the contact ends, from first contact; the robot keeps its speed until it has stopped, or until it brakes."""

    stop_after: float | None = Field(default=None, description="s, after which the robot has stopped")
    travel: float | None = Field(default=None, description="m, what is left of the flange's stroke")
    reaction: float | None = Field(default=None, description="s, from when the robot brakes")
    deceleration: float | None = Field(default=None, description="m/s^2, with which it does")

    @model_validator(mode="after")
    def _can_be(self) -> Self:
        if faults := ending_faults(self.ending()):
            raise ValueError("; ".join(faults))
        return self

    def ending(self) -> Ending:
        """What is given; infinity for the rest."""
        return Ending(**{name: math.inf if x is None else x for name, x in self.model_dump().items()})


def _kind(value: Any) -> str:
    return "range" if isinstance(value, dict | Range) else "number"


def _no_list(value: Any) -> Any:
    if isinstance(value, list):
        raise ValueError(f"must be a number, or {{low: ..., high: ...}}, but is {shown(value)}; correct it")
    return value


Fixed = Annotated[float, Field(ge=0), Tag("number")]
Quantity = Annotated[Fixed | Annotated[Range, Tag("range")], Discriminator(_kind), BeforeValidator(_no_list)]


class Config(Part):
    """A number is given, a range is free."""

    model: Path = Field(description="a rig's YAML file or a diagnosis' model.json, beside this file")
    surrogate: Path | None = Field(default=None, description="a model.eqx in place of the rig's closed form")
    limit: float = Field(gt=0, description="N, of the peak contact force")
    probability: float = Field(default=0.95, ge=0.5, le=0.9999, description="that the limit holds")
    f_p: Quantity = Field(description="N, pretension, which sets the process force")
    v_e: Quantity = Field(description="m/s, contact velocity")
    free: dict[str, Range] = Field(default={}, description="further parameters of the model")
    relative_std: dict[str, Share] = Field(default={}, description="standard deviation over value")
    ending: End = Field(
        default=End(), description="how the contact ends; the first peak alone counts without"
    )
    starts: int = Field(default=32, ge=1, le=1024)
    draws: int = Field(default=8192, ge=256, le=2**20)
    seed: int = Field(default=0, ge=0, lt=2**31)
    goal: Goal  # last: its validator sees all others that are sound, whatever is wrong with the rest

    @field_validator("limit", *IMPACT)
    @classmethod
    def _is_in_si_units(cls, value: float | Range, info: ValidationInfo) -> float | Range:
        if fault := _unit_fault(str(info.field_name), _span(value)):
            raise ValueError(fault)
        return value

    @field_validator("goal")
    @classmethod
    def _can_be_asked(cls, value: Goal, info: ValidationInfo) -> Goal:
        known, coordinate = info.data, COORDINATE[value]
        if coordinate and isinstance(known.get(coordinate), float):
            remedy = f"write {coordinate}: {{low: ..., high: ...}}, or choose another goal"
            raise ValueError(f"{value} needs {coordinate} to be free; {remedy}")
        is_fixed = all(isinstance(known.get(name), float) for name in IMPACT) and known.get("free") == {}
        if not coordinate and is_fixed:
            raise ValueError(
                "widest_margin needs something free; give f_p or v_e a range, or name it below free"
            )
        return value

    def ranges(self) -> dict[str, Range]:
        """What is free, by name."""
        own = {name: getattr(self, name) for name in ("v_e", "f_p")}
        return {name: value for name, value in own.items() if isinstance(value, Range)} | self.free


def _span(value: float | Range) -> Span:
    """Lowest and highest value."""
    return (value.low, value.high) if isinstance(value, Range) else (value, value)


def _unit_fault(name: str, span: Span) -> str | None:
    """Why a quantity, or an end of its range, must be in another unit."""
    low, high = span
    ends = {"": low} if low == high else {"low ": low, "high ": high}
    return next((end + fault for end, x in ends.items() if (fault := unit_fault(name, x))), None)


def _further_faults(spans: Mapping[str, Span | None]) -> list[str]:
    """What is wrong with further free parameters, of which some may have no sound range."""
    faults = [f"{name}: give its range at the key {name}; remove it here" for name in IMPACT if name in spans]
    for name, span in spans.items():
        if span is None or name in IMPACT:
            continue
        if name in POSITIVE and span[0] == 0:
            faults.append(f"{name}: low must be above 0; the model needs a positive {name}")
        elif fault := _unit_fault(name, span):
            faults.append(f"{name}: {fault}")
    return faults


class Question(NamedTuple):
    """A configuration, or as much of it as can be looked at further."""

    config: Config | None  # None where anything is wrong
    content: dict[str, Any]  # as it stands in the file
    faults: list[str]

    def names(self, key: str) -> list[str]:
        """The names below `free` or `relative_std`, sound or not."""
        given = self.content.get(key)
        return [str(name) for name in given] if isinstance(given, Mapping) else []

    def spans(self) -> dict[str, Span]:
        """Lowest and highest value of whatever has a sound one."""
        free = self.content.get("free")
        given: dict[str, Any] = dict(free) if isinstance(free, Mapping) else {}
        given |= {name: self.content.get(name) for name in IMPACT}
        spans = {}
        for name, value in given.items():
            try:
                sound = _QUANTITY.validate_json(json.dumps(value), strict=True)
            except ValidationError:
                continue
            spans[str(name)] = _span(sound)
        return spans


_QUANTITY: TypeAdapter[float | Range] = TypeAdapter(Quantity)


def read_question(path: Path) -> Question:
    """What a file asks, with every fault of it; `InputError` where the file holds no mapping."""
    return make_question(read_yaml_mapping(path), path)


def make_question(content: dict[str, Any], where: Path | str) -> Question:
    """What the content of such a file asks; every fault begins with `where`."""
    config, faults = None, []
    try:
        config = check_form(Config, content, where)
    except InputError as error:
        faults = error.faults
    question = Question(config, content, faults)
    spans = question.spans()
    further = _further_faults({name: spans.get(name) for name in question.names("free")})
    faults += [f"{where}: free.{fault}" for fault in further]
    return question._replace(config=None) if faults else question


def read_config(path: Path) -> Config:
    """The question in a file; `InputError` lists every fault."""
    question = read_question(path)
    if question.config is None:
        raise InputError(question.faults)
    return question.config

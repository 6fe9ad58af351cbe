"""The question of a design, design.yaml: one frozen model, every fault at once."""

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, ValidationError, model_validator

from acf_jax.errors import InputError, shown
from acf_jax.files import read_yaml_mapping

Goal = Literal["fastest", "highest_process_force", "widest_margin"]
COORDINATE: dict[str, str | None] = {"fastest": "v_e", "highest_process_force": "f_p", "widest_margin": None}


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Range(_Part):
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


def _kind(value: Any) -> str:
    return "range" if isinstance(value, dict | Range) else "number"


Quantity = Annotated[Annotated[float, Tag("number")] | Annotated[Range, Tag("range")], Discriminator(_kind)]


class Config(_Part):
    """A number is given, a range is free."""

    model: Path = Field(description="a rig's YAML file or a diagnosis' model.json, beside this file")
    surrogate: Path | None = Field(default=None, description="a model.eqx in place of the rig's closed form")
    goal: Goal
    limit: float = Field(gt=0, description="N, of the peak contact force")
    probability: float = Field(default=0.95, ge=0.5, le=0.9999, description="that the limit holds")
    f_p: Quantity = Field(description="N, pretension, which sets the process force")
    v_e: Quantity = Field(description="m/s, contact velocity")
    free: dict[str, Range] = Field(default={}, description="further parameters of the model")
    relative_std: dict[str, float] = Field(default={}, description="standard deviation over value")
    starts: int = Field(default=32, ge=1, le=1024)
    draws: int = Field(default=8192, ge=256, le=2**20)
    seed: int = Field(default=0, ge=0, lt=2**31)

    @model_validator(mode="after")
    def _is_a_question(self) -> Self:
        faults = []
        for name in ("f_p", "v_e"):
            value = getattr(self, name)
            if isinstance(value, float) and value < 0:
                faults.append(f"{name} must be zero or positive, but is {value:g}; correct it")
            if name in self.free:
                faults.append(f"free.{name}: give its range at the key {name}; remove it here")
        coordinate = COORDINATE[self.goal]
        if coordinate and not isinstance(getattr(self, coordinate), Range):
            remedy = f"write {coordinate}: {{low: ..., high: ...}}, or choose another goal"
            faults.append(f"goal {self.goal} needs {coordinate} to be free; {remedy}")
        if not coordinate and not self.ranges():
            faults.append(
                "goal widest_margin needs something free; give f_p or v_e a range, or name it below free"
            )
        faults += [
            f"relative_std.{name} must lie between 0 and 0.5, but is {value:g}; give a share of the value"
            for name, value in self.relative_std.items()
            if not 0 <= value <= 0.5
        ]
        if faults:
            raise ValueError("\n".join(faults))
        return self

    def ranges(self) -> dict[str, Range]:
        """What is free, by name."""
        own = {name: getattr(self, name) for name in ("v_e", "f_p")}
        return {name: value for name, value in own.items() if isinstance(value, Range)} | self.free


def read_config(path: Path) -> Config:
    """The question in a file; `InputError` lists every fault."""
    try:
        return Config.model_validate(read_yaml_mapping(path))
    except ValidationError as error:
        faults = [line for fault in error.errors() for line in _lines(path, dict(fault))]
        raise InputError(faults) from None


_REMEDIES = {
    "extra_forbidden": "unknown key; remove it or correct its spelling",
    "missing": "is missing; add it",
}


def _lines(path: Path, fault: dict[str, Any]) -> list[str]:
    """A pydantic error as lines `file: dotted.path: problem; remedy`."""
    where = ".".join(str(part) for part in fault["loc"] if part not in ("number", "range"))
    where = f"{path}: {where}: " if where else f"{path}: "
    if fault["type"] == "value_error":
        return [where + problem for problem in str(fault["ctx"]["error"]).split("\n")]
    if fault["type"] in _REMEDIES:
        return [where + _REMEDIES[fault["type"]]]
    if fault["loc"][-1:] == ("number",):
        return [
            where
            + f"must be a number, or {{low: ..., high: ...}}, but is {shown(fault['input'])}; correct it"
        ]
    return [where + f"{fault['msg'].lower()}, but is {shown(fault['input'])}; correct the value"]

"""Which topic or column holds what: one frozen model, from the command line, a YAML file, or both."""

import re
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Discriminator, Field, Tag, ValidationError, model_validator

from acf_jax.errors import InputError, shown
from acf_jax.files import read_yaml_mapping
from acf_jax.forms import Part, problems, validated

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_OPTIONS = {"sample_rate_hz": "rate"}  # keys whose option is called otherwise
_TEXT = re.compile(rf"(?:(?P<scale>{_NUMBER})\*)?(?P<name>.+)", re.DOTALL)


class Source(Part):
    """One signal of a recording: `[SCALE*]NAME`, `[SCALE*]/TOPIC[:FIELD]`, or these keys."""

    name: str = Field(min_length=1, description="topic, column or array")
    field: str | None = Field(
        default=None, description="path within a message: z, wrench.force.z, velocity[2]"
    )
    scale: float = Field(default=1.0, description="to SI units, positive in contact or when approaching")
    time: str | None = Field(default=None, description="the column of its own times, in a table")
    recording: str | None = Field(
        default=None,
        min_length=1,
        description="another recording that holds it, from the folder of the first",
    )
    time_scale: float | None = Field(default=None, gt=0, description="s per unit of the times there")
    clock_offset_s: float = Field(
        default=0.0, description="s, added to its times; the clocks are then not compared"
    )

    def __str__(self) -> str:
        return f"{self.name}:{self.field}" if self.field else self.name

    @model_validator(mode="after")
    def _has_a_scale(self) -> Self:
        if self.scale == 0.0:
            raise ValueError("scale must not be 0; give the factor to SI units")
        if self.recording is not None and not self.recording.isprintable():
            raise ValueError(f"recording is {shown(self.recording)}, no path; name a file")
        if self.time_scale is not None and self.recording is None:
            raise ValueError(
                "time_scale is that of another recording; state it beside force, or name a recording"
            )
        return self


def parse_source(text: str) -> Source:
    """The signal that `[SCALE*]NAME` names; behind a topic, which begins with /, a colon and a field may follow."""
    found = _TEXT.fullmatch(text)
    if found is None:
        raise ValueError("names nothing; name a topic or a column")
    scale: dict[str, Any] = {"scale": float(found["scale"])} if found["scale"] else {}
    name = found["name"].strip()
    topic, colon, field = name.partition(":")
    if name.startswith("/") and colon:
        return Source(name=topic, field=field or None, **scale)
    return Source(name=name, **scale)


def _source(value: Any) -> Any:
    if not isinstance(value, str | dict | Source):
        raise ValueError(f"is {shown(value)}, no signal; name a topic or a column")
    return parse_source(value) if isinstance(value, str) else value


def _source_or_number(value: Any) -> Any:
    if isinstance(value, bool | list):
        raise ValueError(f"is {shown(value)}, neither a signal nor a number; name one")
    if isinstance(value, str) and re.fullmatch(_NUMBER, value.strip()):
        return float(value)
    return value if isinstance(value, int | float) else _source(value)


def _kind(value: Any) -> str:
    return "a signal" if isinstance(value, dict | Source) else "a number"


Signal = Annotated[Source, BeforeValidator(_source)]
SignalOrNumber = Annotated[
    Annotated[Source, Tag("a signal")] | Annotated[float, Tag("a number")],
    Discriminator(_kind),
    BeforeValidator(_source_or_number),
]


class Contacts(Part):
    """How contacts are found and cut; the defaults suit impacts of milliseconds."""

    threshold_n: float | None = Field(
        default=None, gt=0, description="N above the approach; else from its noise"
    )
    separation_s: float = Field(default=0.1, gt=0, description="a contact ends when force is gone that long")
    before_s: float = Field(default=0.01, gt=0, description="of the approach in a trace, at least 40 samples")
    after_s: float = Field(default=0.06, gt=0, description="of the contact in a trace")
    tare: bool = Field(default=True, description="take off what the force reads while nothing is touched")


class Mapping(Part):
    """What the signals of a recording are; what is left out is looked for."""

    force: Signal | None = Field(default=None, description="N")
    velocity: SignalOrNumber | None = Field(default=None, description="m/s, robot towards the part")
    position: Signal | None = Field(default=None, description="m, differentiated in place of a velocity")
    pretension: SignalOrNumber | None = Field(default=None, description="N")
    time: str | None = Field(default=None, description="column of the times, in a table; or A+B, their sum")
    time_scale: float | None = Field(default=None, gt=0, description="s per unit of that column")
    sample_rate_hz: float | None = Field(
        default=None, gt=0, lt=1e9, description="of the rows of a table that has no times"
    )
    contacts: Contacts = Contacts()

    @model_validator(mode="after")
    def _has_one_speed_and_time(self) -> Self:
        if self.velocity is not None and self.position is not None:
            raise ValueError("velocity and position are both given; keep one")
        if self.time is not None and self.sample_rate_hz is not None:
            raise ValueError("time and sample_rate_hz are both given; keep one")
        if self.force is not None and self.force.recording is not None:
            raise ValueError("the force is that of the recording itself; remove 'recording' from force")
        return self


def read_mapping(path: Path | None, options: dict[str, Any], dashes: str = "--") -> Mapping:
    """The mapping of a file, options in place of its keys; `InputError` lists every fault.

    **Arguments:** `dashes`: before an option's name in a message; none before an argument of a program.
    """
    given = {name: value for name, value in options.items() if value is not None}
    content = read_yaml_mapping(path) if path else {}
    for either in (("velocity", "position"), ("time", "sample_rate_hz")):
        if any(key in given for key in either):
            content = {key: value for key, value in content.items() if key not in either}
    if (tare := given.pop("tare", None)) is not None:
        contacts = content.get("contacts")
        content["contacts"] = (contacts if isinstance(contacts, dict) else {}) | {"tare": tare}
    content |= given
    try:
        return validated(Mapping, content)
    except ValidationError as error:
        found = list(problems(Mapping, content, error))
    where = path or "options"
    places = [
        f"{dashes}{_OPTIONS.get(key, key)}" if key in given else f"{where}: {key}" if key else f"{where}"
        for key, _ in found
    ]
    raise InputError([f"{place}: {problem}" for place, (_, problem) in zip(places, found, strict=True)])

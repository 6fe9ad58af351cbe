"""The configuration of a training run: one frozen model, every fault at once."""

import os
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from acf_jax.dataset.rig_file import read_rig
from acf_jax.documents import parse_yaml, yaml_text
from acf_jax.errors import InputError
from acf_jax.files import read_yaml_mapping
from acf_jax.forms import Part, check_form
from acf_jax.surrogate.box import UNITS, sign_fault
from acf_jax.surrogate.load import Shape

FeatureName = Literal["raw", "dimensionless", "fold"]


class Range(Part):
    """Lowest and highest value of one parameter, and how samples spread between them."""

    low: float
    high: float
    unit: str
    scale: Literal["linear", "log"] = "linear"

    @model_validator(mode="after")
    def _is_possible(self) -> Self:
        if self.low >= self.high:
            raise ValueError(f"low ({self.low:g}) must be below high ({self.high:g}); swap or widen them")
        if self.scale == "log" and self.low <= 0:
            raise ValueError(f"a log scale cannot start at {self.low:g}; raise low or use scale: linear")
        return self


class Ranges(Part):
    """The box of parameters; zeta is the damping ratio and sets d = 2 zeta sqrt(m (k_F + k_C))."""

    m: Range
    zeta: Range
    k_f: Range
    k_c: Range
    v_e: Range
    f_p: Range

    @field_validator(*UNITS)
    @classmethod
    def _is_physical(cls, value: Range, info: ValidationInfo) -> Range:
        name = str(info.field_name)
        faults = []
        if value.unit != UNITS[name]:
            faults.append(
                f"unit must be {UNITS[name]}, but is {value.unit}; convert the range to {UNITS[name]}"
            )
        if fault := sign_fault(name, value.low):
            faults.append(fault)
        if faults:
            raise ValueError("\n".join(faults))
        return value


class Samples(Part):
    """How many samples, and by which low-discrepancy design."""

    train: int = Field(ge=1024, le=2**24)
    held_out: int = Field(default=2**18, ge=1024, le=2**24, description="set the error bound")
    test: int = Field(default=2**18, ge=1024, le=2**24, description="give the errors in the report")
    method: Literal["sobol", "latin_hypercube"] = "sobol"


class Optimiser(Part):
    """Adam with a linear warm-up and a cosine decay."""

    learning_rate: float = Field(gt=0, description="highest, reached after the warm-up")
    final_fraction: float = Field(default=1e-4, ge=0, le=1, description="last learning rate/highest")
    warm_up_steps: int = Field(default=500, ge=0)
    steps: int = Field(ge=1, le=10**8)
    batch: int = Field(default=1024, ge=1, le=2**20)
    steps_per_checkpoint: int = Field(default=2000, ge=1)

    @model_validator(mode="after")
    def _has_time_to_decay(self) -> Self:
        if self.warm_up_steps >= self.steps:
            raise ValueError(
                f"warm_up_steps ({self.warm_up_steps}) must be below steps ({self.steps}); "
                "shorten the warm-up"
            )
        return self


class Processes(Part):
    """The processes that train together, each started with the same configuration but for its `id`."""

    coordinator: str = Field(pattern=r"^.+:\d+$", description="host:port at which process 0 is reached")
    count: int = Field(ge=1)
    id: int | None = Field(default=None, ge=0, description="left out: as Slurm, MPI or Kubernetes say")

    @model_validator(mode="after")
    def _is_one_of_them(self) -> Self:
        if self.id is not None and self.id >= self.count:
            raise ValueError(f"id ({self.id}) must be below count ({self.count}); the first process has id 0")
        return self


class TableRig(Part):
    """A rig's parameters."""

    m: float = Field(gt=0)  # kg
    d: float = Field(ge=0)  # N s/m
    k_f: float = Field(ge=0)  # N/m
    k_c: float = Field(gt=0)  # N/m


class Table1(Part):
    """The rig that stands for the paper's in Table 1; F_P and the velocities are the paper's."""

    rig: TableRig


class _Run(Part):
    """What every run depends on."""

    output: Path = Field(description="folder of the run, from the working directory")
    seed: int = Field(default=0, ge=0, lt=2**31)
    precision: Literal["float32", "float64"] = "float32"
    samples: Samples
    network: Shape
    optimiser: Optimiser
    devices: int | None = Field(default=None, ge=1, description="of each process; left out: all it has")
    processes: Processes | None = None


# Keys that change no result: where a run is kept, and by how many it is computed.
_APART = {"output", "devices", "processes"}


class Config(_Run):
    """Everything a run depends on; a run's folder keeps it, resolved, as config.yaml."""

    features: FeatureName = "fold"
    compare: tuple[FeatureName, ...] = Field(default=(), description="trained too, on the same budget")
    ranges: Ranges
    table1: Table1 | None = None

    def identity(self) -> dict[str, Any]:
        """What a run's state depends on."""
        return self.model_dump(mode="json", exclude={"table1", "compare", *_APART})

    @property
    def all_features(self) -> tuple[FeatureName, ...]:
        """The default feature set, then those it is compared with, each once."""
        return tuple(dict.fromkeys((self.features, *self.compare)))


class Labels(Part):
    """Which corrected model to learn, and what of it."""

    model: Path = Field(
        description="the model.json of a diagnosis, or its folder, relative to the configuration's"
    )
    force: Literal["contact", "sensed"] = Field(
        default="contact", description="at the contact, which design and check need, or the sensor's reading"
    )
    deviations: float = Field(
        default=5.0, ge=1, le=10, description="half the range of a fitted parameter, in standard deviations"
    )
    workers: int = Field(default=1, ge=1, le=256, description="processes that label; 1: this one does")
    scheduler: str | None = Field(default=None, description="address of a Dask scheduler whose workers label")


LABELLERS = {"workers", "scheduler"}  # of `labels`: who labels changes no result


class CorrectedConfig(_Run):
    """Everything a run on a corrected model depends on."""

    labels: Labels
    ranges: dict[str, Range] = Field(
        default={}, description="of m, d, k_f, k_c, an effect's parameter, v_e, f_p, mobility (1/m_H)"
    )

    def identity(self) -> dict[str, Any]:
        """What a run's state depends on besides the model."""
        apart: dict[str, Any] = dict.fromkeys(_APART, True)
        return self.model_dump(mode="json", exclude=apart | {"labels": {"model", *LABELLERS}})


AnyConfig = Config | CorrectedConfig


def read_config(path: Path, changes: tuple[str, ...] = ()) -> AnyConfig:
    """The configuration in `path` with `key=value` changes applied; `InputError` lists every fault."""
    values = read_yaml_mapping(path)
    _place_model(path, values)  # what --set names is relative to the working directory
    faults = [fault for change in changes if (fault := _apply(values, change))]
    faults += _include_rig(path, values)
    form: type[AnyConfig] = CorrectedConfig if "labels" in values else Config
    config = None
    try:
        config = check_form(form, values, path)
    except InputError as error:
        faults += error.faults
    if faults or config is None:
        raise InputError(faults)
    return config


def to_yaml(config: AnyConfig) -> str:
    """The configuration with every default written out."""
    return yaml_text(config.model_dump(mode="json"))


def _apply(values: dict[str, Any], change: str) -> str | None:
    """Put one `a.b=value` into `values`; a fault as text."""
    key, equals, text = change.partition("=")
    *parents, last = key.split(".")
    if not equals or not all((*parents, last)):
        return f"--set {change}: must read key=value, such as --set optimiser.steps=1000"
    for parent in parents:
        values = values.setdefault(parent, {})
        if not isinstance(values, dict):
            return f"--set {change}: '{parent}' has no keys below it; shorten the key"
    try:
        values[last] = parse_yaml(text, f"--set {key}")
    except InputError as error:
        return error.faults[0]
    return None


def _place_model(path: Path, values: dict[str, Any]) -> None:
    """Make `labels.model` absolute: the configuration is kept in another folder, too."""
    labels = values.get("labels")
    if isinstance(labels, dict) and isinstance(labels.get("model"), str):
        labels["model"] = os.path.abspath(path.parent / labels["model"])


def _include_rig(path: Path, values: dict[str, Any]) -> list[str]:
    """Replace `table1: file.yaml`, a rig's file beside the configuration, by what it holds."""
    name = values.get("table1")
    if not isinstance(name, str):
        return []
    rig, faults = read_rig(path.parent / name)
    values["table1"] = None if faults else {"rig": rig}
    return [f"{path}: table1: {fault}" for fault in faults]

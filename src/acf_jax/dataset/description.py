"""dataset.yaml: the rig's priors and how it was measured, checked against the contract."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from acf_jax.dataset import units
from acf_jax.dataset.table import suggestion
from acf_jax.dataset.trials import Measurement, Prior, RigPrior
from acf_jax.errors import InputError, shown
from acf_jax.files import read_yaml_mapping

SCHEMA = "acf-gap-dataset/1"


def _number(value: Any) -> Any:
    # pydantic would take yes and true for 1, and '3_4' for 34
    if isinstance(value, bool) or (isinstance(value, str) and "_" in value):
        raise ValueError("must be a number; write digits, such as 3.4e5")
    return value


def _within(limit: units.Limit) -> AfterValidator:
    def check(value: float) -> float:
        if fault := limit.fault(value):
            raise ValueError(fault)
        return value

    return AfterValidator(check)


def _below(limit: units.Limit) -> AfterValidator:
    """Of a standard deviation: more than the largest value that can be is as good as unknown, and breaks a fit."""
    return _within(replace(limit, low=0.0))


Number = Annotated[float, BeforeValidator(_number)]
Std = Annotated[Number, Field(gt=0, allow_inf_nan=False)]


class _Strict(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class _Mass(_Strict):
    value: Annotated[Number, _within(units.MASS)]
    std: Annotated[Std, _below(units.MASS)]


class _Damping(_Strict):
    value: Annotated[Number, _within(units.DAMPING)]
    std: Annotated[Std, _below(units.DAMPING)]


class _ActuatorStiffness(_Strict):
    value: Annotated[Number, _within(units.ACTUATOR_STIFFNESS)]
    std: Annotated[Std, _below(units.ACTUATOR_STIFFNESS)]


class _ContactStiffness(_Strict):
    value: Annotated[Number, _within(units.CONTACT_STIFFNESS)]
    std: Annotated[Std, _below(units.CONTACT_STIFFNESS)]


class _Rig(_Strict):
    moving_mass_kg: _Mass
    damping_n_s_per_m: _Damping
    actuator_stiffness_n_per_m: _ActuatorStiffness
    contact_stiffness_n_per_m: _ContactStiffness


class _Measurement(_Strict):
    force_noise_std_n: Annotated[Number, _within(units.FORCE_NOISE)] | None = None
    contact_velocity_rel_std: Annotated[Number, _within(units.RELATIVE_STD)] = (
        Measurement.contact_velocity_rel_std
    )
    pretension_rel_std: Annotated[Number, _within(units.RELATIVE_STD)] = Measurement.pretension_rel_std


class _Document(_Strict):
    schema_: Literal["acf-gap-dataset/1"] = Field(alias="schema")
    description: str = ""
    rig: _Rig
    measurement: _Measurement = _Measurement()


def read_description(path: Path) -> tuple[str, RigPrior, Measurement]:
    """Description, rig prior and measurement of a dataset.yaml; `InputError` with all its faults."""
    return check_description(path, read_yaml_mapping(path))


def check_description(path: Path, mapping: dict[str, Any]) -> tuple[str, RigPrior, Measurement]:
    """The same of a mapping that was read from `path`."""
    try:
        document = _Document.model_validate(mapping)
    except ValidationError as error:
        raise InputError([_fault(path, detail) for detail in error.errors(include_url=False)]) from None
    rig, measurement = document.rig, document.measurement
    priors = (
        Prior(known.value, known.std)
        for known in (
            rig.moving_mass_kg,
            rig.damping_n_s_per_m,
            rig.actuator_stiffness_n_per_m,
            rig.contact_stiffness_n_per_m,
        )
    )
    return document.description, RigPrior(*priors), Measurement(**measurement.model_dump())


def _fault(path: Path, detail: Any) -> str:
    """One sentence for one of pydantic's errors: file, dotted key, what is wrong, remedy."""
    location = [str(part) for part in detail["loc"]]
    key, kind = ".".join(location), detail["type"]
    if kind == "missing":
        what = "is missing; add it"
    elif kind in ("extra_forbidden", "invalid_key"):
        what = f"is not a known key{suggestion(location[-1], _keys(location[:-1])) or '; remove it'}"
    elif key == "schema":
        what = f"must be {SCHEMA}; correct it, or use the version of acf-jax that knows this schema"
    elif kind == "value_error":
        what = str(detail["ctx"]["error"])
    elif kind in ("model_type", "model_attributes_type", "dict_type"):
        what = "must hold `key: value` pairs; see the example in docs/data_format.md"
    elif key.endswith(".std") or kind == "finite_number":
        what = "must be a number above 0; give the standard deviation in the unit of the value"
    elif kind == "string_type":
        what = "must be text; put it in quotes"
    else:
        what = "must be a number; write digits, such as 3.4e5"
    return f"{path} key {shown(key)}: {what}"


def _keys(location: list[str]) -> list[str]:
    """The keys known at a place in the document."""
    model: type[BaseModel] = _Document
    for part in location:
        annotation = model.model_fields[part].annotation if part in model.model_fields else None
        if not (isinstance(annotation, type) and issubclass(annotation, BaseModel)):
            return []
        model = annotation
    return [f.alias or name for name, f in model.model_fields.items()]

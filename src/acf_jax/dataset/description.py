"""dataset.yaml: the rig's priors and how it was measured, checked against the contract."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from acf_jax.dataset import units
from acf_jax.dataset.trials import Measurement, Prior, RigPrior
from acf_jax.files import read_yaml_mapping
from acf_jax.forms import Part, check_form

SCHEMA = "acf-gap-dataset/1"


def _within(limit: units.Limit) -> AfterValidator:
    def check(value: float) -> float:
        if fault := limit.fault(value):
            raise ValueError(fault)
        return value

    return AfterValidator(check)


def _is_a_deviation(value: float) -> float:
    if value <= 0:
        raise ValueError("must be a number above 0; give the standard deviation in the unit of the value")
    return value


def _below(limit: units.Limit) -> AfterValidator:
    """Of a standard deviation: more than the largest value that can be is as good as unknown, and breaks a fit."""
    return _within(replace(limit, low=0.0))


Std = Annotated[float, AfterValidator(_is_a_deviation)]


class _Mass(Part):
    value: Annotated[float, _within(units.MASS)]
    std: Annotated[Std, _below(units.MASS)]


class _Damping(Part):
    value: Annotated[float, _within(units.DAMPING)]
    std: Annotated[Std, _below(units.DAMPING)]


class _ActuatorStiffness(Part):
    value: Annotated[float, _within(units.ACTUATOR_STIFFNESS)]
    std: Annotated[Std, _below(units.ACTUATOR_STIFFNESS)]


class _ContactStiffness(Part):
    value: Annotated[float, _within(units.CONTACT_STIFFNESS)]
    std: Annotated[Std, _below(units.CONTACT_STIFFNESS)]


class _Rig(Part):
    moving_mass_kg: _Mass
    damping_n_s_per_m: _Damping
    actuator_stiffness_n_per_m: _ActuatorStiffness
    contact_stiffness_n_per_m: _ContactStiffness


class _Measurement(Part):
    force_noise_std_n: Annotated[float, _within(units.FORCE_NOISE)] | None = None
    contact_velocity_rel_std: Annotated[float, _within(units.RELATIVE_STD)] = (
        Measurement.contact_velocity_rel_std
    )
    pretension_rel_std: Annotated[float, _within(units.RELATIVE_STD)] = Measurement.pretension_rel_std


class _Document(Part):
    schema_: Literal["acf-gap-dataset/1"] = Field(alias="schema")
    description: str = ""
    rig: _Rig
    measurement: _Measurement = _Measurement()


def read_description(path: Path) -> tuple[str, RigPrior, Measurement]:
    """Description, rig prior and measurement of a dataset.yaml; `InputError` with all its faults."""
    return check_description(path, read_yaml_mapping(path))


def check_description(path: Path, mapping: dict[str, Any]) -> tuple[str, RigPrior, Measurement]:
    """The same of a mapping that was read from `path`."""
    document = check_form(_Document, mapping, path)
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

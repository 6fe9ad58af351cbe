"""dataset.yaml: the rig's priors and how it was measured, checked against the contract."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from acf_jax.dataset import units
from acf_jax.dataset.rig_file import KEYS, as_prior
from acf_jax.dataset.trials import LowPass, Measurement, Prior, RigPrior
from acf_jax.errors import InputError
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


class LowPassForm(Part):
    """A `LowPass` as files state it."""

    cutoff_hz: Annotated[float, _within(units.CUTOFF)]
    order: Annotated[int, Field(ge=1, le=10)] = LowPass.order
    zero_phase: bool = LowPass.zero_phase

    @property
    def filter(self) -> LowPass:
        """What is stated."""
        return LowPass(**self.model_dump())


class _Measurement(Part):
    force_noise_std_n: Annotated[float, _within(units.FORCE_NOISE)] | None = None
    contact_velocity_rel_std: Annotated[float, _within(units.RELATIVE_STD)] = (
        Measurement.contact_velocity_rel_std
    )
    pretension_rel_std: Annotated[float, _within(units.RELATIVE_STD)] = Measurement.pretension_rel_std
    range_n: Annotated[float, _within(units.SENSOR_RANGE)] | None = None
    low_pass: LowPassForm | None = None
    tool_mass_kg: Annotated[float, _within(units.MASS)] | None = None
    robot_velocity_std_m_per_s: Annotated[float, _within(units.ROBOT_VELOCITY_STD)] | None = None


class _Document(Part):
    schema_: Literal["acf-gap-dataset/1"] = Field(alias="schema")
    description: str = ""
    rig: _Rig
    measurement: _Measurement = _Measurement()


def check_prior(values: Mapping[str, tuple[Any, Any]], where: str) -> RigPrior:
    """The prior of value and standard deviation of m, d, k_f and k_c, SI units.

    **Raises:** `InputError` that lists every fault as `where.m.value: what is wrong; remedy`.
    """
    content = {KEYS[name]: {"value": value, "std": std} for name, (value, std) in values.items()}
    try:
        return _prior(check_form(_Rig, content, where))
    except InputError as error:
        called = {key: name for name, key in KEYS.items()}
        raise InputError(_renamed(error.faults, f"{where}: ", f"{where}.", called)) from None


def read_description(path: Path) -> tuple[str, RigPrior, Measurement]:
    """Description, rig prior and measurement of a dataset.yaml; `InputError` with all its faults."""
    return check_description(path, read_yaml_mapping(path))


def check_rig(path: Path, mapping: dict[str, Any]) -> tuple[str, RigPrior, Measurement]:
    """The same of a rig's file, or of a dataset.yaml: a rig's file needs no schema."""
    return check_description(path, {"schema": SCHEMA} | mapping)


def check_description(path: Path, mapping: dict[str, Any]) -> tuple[str, RigPrior, Measurement]:
    """The same of a mapping that was read from `path`."""
    content, called, faults = as_prior(mapping, str(path))
    try:
        document = check_form(_Document, content, path)
    except InputError as error:
        faults += _renamed(error.faults, f"{path}: rig.", f"{path}: rig.", called)
    if faults:
        raise InputError(faults)
    measurement, moving = document.measurement, document.rig.moving_mass_kg.value
    if measurement.tool_mass_kg and measurement.tool_mass_kg > moving:
        raise InputError(
            f"{path}: measurement.tool_mass_kg: is {measurement.tool_mass_kg:g} kg, more than all that moves"
            f" (rig.moving_mass_kg is {moving:g}); state what lies between the contact and the sensor"
        )
    known = measurement.model_dump() | {"low_pass": measurement.low_pass and measurement.low_pass.filter}
    return document.description, _prior(document.rig), Measurement(**known)


def _renamed(faults: Sequence[str], before: str, after: str, called: Mapping[str, str]) -> list[str]:
    """Faults with what the user calls a parameter in place of the form's key, between `before` and its own end."""
    key = re.compile(rf"^{re.escape(before)}({'|'.join(map(re.escape, called)) or '$'})\b")
    return [key.sub(lambda found: f"{after}{called[found[1]]}", fault) for fault in faults]


def _prior(rig: _Rig) -> RigPrior:
    known = (getattr(rig, key) for key in KEYS.values())
    return RigPrior(*(Prior(part.value, part.std) for part in known))

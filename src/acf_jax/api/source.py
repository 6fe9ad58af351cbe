"""What stands behind an answer: the law of a rig, of a diagnosis, or of a surrogate that was trained on one."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np

from acf_jax.api._values import begin, path_of
from acf_jax.contact.model import ContactModel
from acf_jax.contact.model_file import ModelFile
from acf_jax.contact.peak import RIG
from acf_jax.contact.read import by_surrogate, of_diagnosis, of_rig
from acf_jax.diagnosis import Diagnosis
from acf_jax.diagnosis.results import gap_model
from acf_jax.errors import InputError, shown
from acf_jax.gap_model import GapModel
from acf_jax.model import Rig
from acf_jax.safety.check import Checker
from acf_jax.surrogate import CorrectedSurrogate


@dataclass(frozen=True, eq=False)
class Source:
    """The law and what is known of it."""

    exact: ContactModel  # without a surrogate
    gap: GapModel | None = None  # what a diagnosis left; None: the paper's model of a rig
    trained: CorrectedSurrogate | None = None
    stored: bytes = b""  # the surrogate's file
    checkers: dict[tuple[float, bool], Checker] = field(
        default_factory=dict
    )  # compiled with their first answer

    @property
    def model(self) -> ContactModel:
        """What answers: the surrogate, where there is one, else the law itself."""
        return self.exact if self.trained is None else by_surrogate(self.exact, self.trained)


class HasSource(Protocol):
    """A model, or a diagnosis."""

    @property
    def source(self) -> Source: ...


ModelLike = HasSource | GapModel | Diagnosis | Rig | str | Path


def source_of(model: ModelLike) -> Source:
    """The law behind whatever stands for a model; JAX is in float64 from here on."""
    begin()
    found = getattr(model, "source", None)
    if isinstance(found, Source):
        return found
    if isinstance(model, Diagnosis):
        return of_gap(gap_model(model), f"the diagnosis of {model.dataset.folder}")
    if isinstance(model, GapModel):
        return of_gap(model, "a diagnosis")
    if isinstance(model, Rig):
        return _of_rig(model)
    if isinstance(model, str | Path):
        return _of_file(path_of(model))
    remedy = "give a diagnosis, a Rig, or the path of a rig's file, of a diagnosis or of a model.eqx"
    raise InputError(f"model: is {shown(model)}, no model; {remedy}")


def of_gap(gap: GapModel, name: str) -> Source:
    """The model that a diagnosis leaves; `name`: what answers call it."""
    return Source(of_diagnosis(gap, source=name), gap)


def _of_rig(rig: Rig) -> Source:
    values = {name: np.asarray(getattr(rig, name)) for name in RIG}
    if many := [name for name, value in values.items() if value.shape]:
        raise InputError(f"Rig.{many[0]}: must be one number here, but has shape {values[many[0]].shape}")
    return Source(of_rig({name: float(value) for name, value in values.items()}, {}))


def _of_file(path: Path) -> Source:
    file = ModelFile(path)
    gap, trained = file.load_gap()
    if gap is None:
        return Source(file.load())
    exact = of_diagnosis(gap, source=str(file.path))
    return Source(exact, gap, trained, file.path.read_bytes() if trained is not None else b"")

"""The model that `design`, `speed` and `check` work with: a rig's YAML file or a diagnosis' model.json."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acf_jax.cli._rig import RIG, read_rig
from acf_jax.errors import InputError, shown
from acf_jax.files import read_json_mapping, read_yaml_mapping

if TYPE_CHECKING:
    from acf_jax.contact.model import ContactModel

IMPACT = ("v_e", "f_p")
HELP = "A rig's YAML file (rig, and if known relative_std and tried), or a diagnosis' model.json."


class ModelFile:
    """A model file whose form has been checked; `load` needs JAX, this does not."""

    def __init__(
        self, path: Path, relative_std: Mapping[str, float] | None = None, surrogate: Path | None = None
    ):
        self.path, self.surrogate = path, surrogate
        self.rig: dict[str, float] = {}
        self.relative_std = dict(relative_std or {})
        self.tried: tuple[tuple[float, float], tuple[float, float]] | None = None
        faults: list[str] = []
        if path.is_dir():
            self.path = path / "model.json"  # a diagnosis' folder
        if self.is_diagnosis:
            faults += self._check_json()
            faults += [
                f"relative_std.{name}: of a diagnosis only v_e and f_p are free to give; its fit tells the rest"
                for name in self.relative_std
                if name not in IMPACT
            ]
            if surrogate is not None:
                faults.append(
                    f"{surrogate}: a surrogate stands for the paper's model; name a rig's YAML file as model"
                )
        else:
            faults += self._read_rig()
        if surrogate is not None and str(surrogate) != "shipped" and not surrogate.is_file():
            faults.append(f"{surrogate}: no such file; name a model.eqx that train.fit wrote, or `shipped`")
        if faults:
            raise InputError(faults)

    @property
    def is_diagnosis(self) -> bool:
        """Whether the file is a diagnosis' model rather than a rig's four values."""
        return self.path.suffix.lower() == ".json"

    def load(self) -> "ContactModel":
        """The model; JAX must have been started."""
        from acf_jax.contact.read import of_diagnosis, of_rig

        if self.is_diagnosis:
            from acf_jax.diagnosis.model_file import read_model

            return of_diagnosis(read_model(self.path), self.relative_std, str(self.path))
        surrogate = None
        if self.surrogate is not None:
            from acf_jax.surrogate import load_surrogate

            surrogate = load_surrogate(None if str(self.surrogate) == "shipped" else self.surrogate)
        return of_rig(self.rig, self.relative_std, surrogate, self.tried, str(self.path))

    def _check_json(self) -> list[str]:
        try:
            content = read_json_mapping(self.path, "use the model.json that `diagnose` wrote")
        except InputError as error:
            return error.faults
        if content.get("schema") != "acf-gap-model/1":
            return [
                f"{self.path}: its schema is not acf-gap-model/1; use the model.json that `diagnose` wrote"
            ]
        return []

    def _read_rig(self) -> list[str]:
        asked = [
            f"relative_std.{name}: is not a quantity of the model; known are {', '.join((*RIG, *IMPACT))}"
            for name in self.relative_std
            if name not in (*RIG, *IMPACT)
        ]
        try:
            content = read_yaml_mapping(self.path)
        except InputError as error:
            return error.faults + asked
        given = content.get("relative_std", {})
        self.rig, faults = read_rig(self.path)
        faults += asked
        faults += [
            f"{self.path} {key}: is not known; use rig, relative_std and tried"
            for key in content
            if key not in ("rig", "relative_std", "tried")
        ]
        faults += self._read_tried(content.get("tried"))
        if not isinstance(given, Mapping):
            return [*faults, f"{self.path} relative_std: must hold `name: share` pairs; correct it"]
        self.relative_std = dict(given) | self.relative_std
        return faults + [
            f"{self.path} relative_std.{name}: {fault}"
            for name, value in given.items()
            if (fault := _share_fault(name, value))
        ]

    def _read_tried(self, given: Any) -> list[str]:
        if given is None:
            return []
        remedy = "write tried: {v_e: [low, high], f_p: [low, high]}"
        if not isinstance(given, Mapping) or set(given) != set(IMPACT):
            return [f"{self.path} tried: must name v_e and f_p; {remedy}"]
        ranges = {name: given[name] for name in IMPACT}
        wrong = [name for name, r in ranges.items() if not _is_range(r)]
        if not wrong:
            (v_low, v_high), (f_low, f_high) = ranges.values()
            self.tried = (float(v_low), float(v_high)), (float(f_low), float(f_high))
        return [f"{self.path} tried.{name}: must be two numbers, the lower first; {remedy}" for name in wrong]


def _is_range(value: Any) -> bool:
    numbers = isinstance(value, list) and len(value) == 2 and all(isinstance(x, int | float) for x in value)
    return numbers and 0 <= value[0] < value[1] < math.inf


def _share_fault(name: Any, value: Any) -> str | None:
    if name not in (*RIG, *IMPACT):
        return f"is not known; use {', '.join((*RIG, *IMPACT))}"
    number = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    return (
        None
        if number and 0 <= value <= 0.5
        else f"must be a share from 0 to 0.5, but is {shown(value)}; correct it"
    )

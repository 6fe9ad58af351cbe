"""`model.json`: the corrected model with its uncertainty, for `predict`, `design`, `check` and training."""

import json
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, ConfigDict, Field

from acf_jax.dataset import Measurement
from acf_jax.dataset.description import LowPassForm
from acf_jax.dataset.tried import Tried
from acf_jax.errors import InputError
from acf_jax.files import read_json_mapping
from acf_jax.forms import Part, check_form
from acf_jax.inference.observations import LONGEST_INTERVAL, SHORTEST_INTERVAL
from acf_jax.inference.parameters import RIG_BOUNDS, every_effect, parameters

SCHEMA: Literal["acf-gap-model/1"] = "acf-gap-model/1"
ROUNDING = 1e-6
LONGEST_STEP_S = (
    1.0  # of a simulation: a tenth of a radian of the slowest rig that a data set may state is 0.02 s
)
LACKS = {
    "traces": "its trials hold peaks and no force traces",
    "detection": "most effects would not have shown in its trials",
    "separation": "its trials leave too many explanations standing",
    None: "its trials could not have told what causes the gap",
}
Which = Literal["nominal", "recalibrated", "corrected"]
Verdict = Literal["no_gap", "identified", "ambiguous", "unknown", "insufficient_data"]
Lack = Literal["traces", "detection", "separation"]
FORM_MOST = 10.0  # relative error of a peak; a law that misses more says nothing of one
LATEST_S = 0.01  # a reading is late by at most this, or early


def _in_order(value: tuple[float, float]) -> tuple[float, float]:
    if not 0 <= value[0] <= value[1]:
        raise ValueError("the lower end must come first, zero or positive")
    return value


Condition = tuple[Annotated[float, Field(ge=0)], Annotated[float, Field(ge=0)]]  # v_E in m/s, F_P in N
Spread = Annotated[float, Field(ge=0, le=1)]
Between = Annotated[tuple[float, float], AfterValidator(_in_order)]


class Variant(Part):
    """One parameter set: an explanation, its parameters in SI units, and their covariance."""

    effects: tuple[str, ...]
    probability: float = Field(ge=0, le=1)
    names: tuple[str, ...]
    theta: tuple[float, ...]
    covariance: tuple[tuple[float, ...], ...]
    delay_s: float = Field(default=0.0, ge=-LATEST_S, le=LATEST_S)  # by which the sensor reads later
    forms: tuple[int, ...] | None = None  # of the laws, one an effect; earlier versions have none


class Proposed(Part):
    """The trial that best separates what still stands."""

    contact_velocity_m_per_s: float = Field(ge=0)
    pretension_n: float = Field(ge=0)
    repeats: int = Field(ge=1)


class GapModel(Part):
    """The content of `model.json`."""

    model_config = ConfigDict(populate_by_name=True)

    schema_: Literal["acf-gap-model/1"] = Field(alias="schema")
    description: str
    nominal: Variant
    recalibrated: Variant
    corrected: Variant
    alternatives: tuple[Variant, ...]  # explanations still standing beside the corrected model
    peak_form_error: float = Field(ge=0, le=FORM_MOST)  # relative, of held-out peaks beyond noise
    step_s: float = Field(gt=0, le=LONGEST_STEP_S)  # of the integration
    sample_rate_hz: float = Field(ge=1 / LONGEST_INTERVAL, le=1 / SHORTEST_INTERVAL)
    v_range: Between  # m/s, contact velocities of the trials
    f_p_range: Between  # N, pretensions of the trials
    verdict: Verdict | None = None  # of the diagnosis; files of earlier versions have none
    corners: tuple[Condition, ...] = ()  # of the region that the trials enclose; earlier versions have none
    rel_std: tuple[Spread, Spread] | None = None  # of v_E and F_P, trial to trial; earlier versions have none
    shown_closer: bool | None = (
        None  # corrected than recalibrated, by what was held out; earlier versions: none
    )
    better: bool | None = (
        None  # than the recalibrated model, by the figures on held-out conditions; None: not asked
    )
    recalibrated_form_error: float = Field(default=0.0, ge=0, le=FORM_MOST)  # as `peak_form_error`
    low_pass: LowPassForm | None = None  # that readings have been through, and so do predicted ones
    tool_mass_kg: float | None = Field(
        default=None, gt=0, le=RIG_BOUNDS[0][1]
    )  # between contact and sensor, of predicted ones, too

    lack: Lack | None = (
        None  # what too little data are short of; None for other verdicts and earlier versions
    )
    next_experiment: Proposed | None = None
    made_by: str | None = None  # program and version; earlier versions have none
    data_sha256: str | None = None  # of the data set that was diagnosed; earlier versions have none

    @property
    def missing(self) -> str:
        """What too little data are short of, and which trials to add; empty for every other verdict."""
        if self.verdict != "insufficient_data":
            return ""
        add = "add trials at other speeds and pretensions (`plan` tells what they would show)"
        if self.lack == "traces":
            add = "record force traces, at 5 kHz or faster and with 20 samples before contact"
        elif (e := self.next_experiment) is not None:
            add = f"add {e.repeats} trials at {e.contact_velocity_m_per_s:.3g} m/s and {e.pretension_n:.3g} N"
        return f"{LACKS[self.lack]}; {add}, then diagnose again"

    @property
    def scatter(self) -> tuple[float, float]:
        """Relative standard deviation of v_E and F_P, trial to trial; of earlier versions a data set's default."""
        usual = Measurement()
        return self.rel_std or (usual.contact_velocity_rel_std, usual.pretension_rel_std)

    @property
    def tried(self) -> Tried:
        """The conditions that its trials stand behind."""
        return Tried(self.v_range, self.f_p_range, self.corners, self.scatter)

    @property
    def preferred(self) -> Which:
        """The model that answers where none is asked for: the corrected one unless it is known to be no better."""
        return "recalibrated" if self.better is False else "corrected"

    def form_error(self, which: Which) -> float:
        """Relative standard deviation of a peak on held-out conditions beyond noise: what the law itself misses."""
        return {"corrected": self.peak_form_error, "recalibrated": self.recalibrated_form_error}.get(
            which, 0.0
        )


def write_model(model: GapModel) -> str:
    """The text of `model.json`."""
    return json.dumps(model.model_dump(mode="json", by_alias=True, exclude_none=True), indent=1) + "\n"


def read_model(path: Path) -> GapModel:
    """The model in a file; `InputError` names what is wrong with it."""
    return check_model(path, read_json_mapping(path, "use the model.json that `diagnose` wrote"))


def check_model(path: Path, content: dict[str, Any]) -> GapModel:
    """The model in what a file holds; `InputError` names what is wrong with it."""
    model = check_form(GapModel, content, path, "write it anew with `diagnose`")
    faults = []
    for name in ("nominal", "recalibrated", "corrected"):
        faults += _faults(path, name, getattr(model, name))
    for k, alternative in enumerate(model.alternatives):
        faults += _faults(path, f"alternatives.{k}", alternative)
    ends = [(min(axis), max(axis)) for axis in zip(*model.corners, strict=True)]
    tried = [model.v_range, model.f_p_range]
    if model.corners and not np.allclose(ends, tried, rtol=ROUNDING, atol=0):
        faults.append(f"{path}: corners: must span v_range and f_p_range; write it anew with `diagnose`")
    if faults:
        raise InputError(faults)
    return model


def _faults(path: Path, where: str, v: Variant) -> list[str]:
    """What pydantic cannot see: names that this version knows, shapes that fit, values that can be."""
    strange = [e for e in v.effects if e not in every_effect()]
    if strange:
        return [
            f"{path}: {where}.effects: unknown effect '{strange[0]}'; this version knows {', '.join(every_effect())}"
        ]
    if v.forms is not None and len(v.forms) != len(v.effects):
        return [
            f"{path}: {where}.forms: holds {len(v.forms)} numbers for {len(v.effects)} effects; write it anew with"
            " `diagnose`"
        ]
    if changed := _changed(v):
        return [
            f"{path}: {where}: was fitted with another form of {', '.join(changed)} than this version has; diagnose the"
            " data again, and train a surrogate of it again"
        ]
    names = tuple(name for name, _ in parameters(v.effects))
    if v.names != names:
        other = [name for name in v.names if name not in names]
        what = f"this version knows no '{other[0]}'" if other else f"must be {list(names)}"
        return [f"{path}: {where}.names: {what}; diagnose the data again, which writes the file anew"]
    if (
        len(v.theta) != len(names)
        or any(len(row) != len(names) for row in v.covariance)
        or len(v.covariance) != len(names)
    ):
        return [
            f"{path}: {where}: needs {len(names)} values and a square covariance; write it anew with `diagnose`"
        ]
    bounds = [*RIG_BOUNDS, *((p.low, p.high) for _, p in parameters(v.effects)[len(RIG_BOUNDS) :])]
    faults = [
        f"{path}: {where}.theta: {name} is {value:g}, but must lie within {low:g} and {high:g}; write it anew"
        for name, value, (low, high) in zip(names, v.theta, bounds, strict=True)
        if not low - ROUNDING * abs(low) <= value <= high + ROUNDING * abs(high)
    ]
    if not faults and not _is_covariance(np.array(v.covariance)):
        faults.append(f"{path}: {where}.covariance: is none (not symmetric, or negative); write it anew")
    return faults


def forms(effects: tuple[str, ...]) -> tuple[int, ...]:
    """The forms that the laws of these effects have in this version."""
    return tuple(every_effect()[name].form for name in effects)


def _changed(v: Variant) -> list[str]:
    """The effects whose law was another one when the model was fitted."""
    if v.forms is None:
        return []
    return [name for name, then, now in zip(v.effects, v.forms, forms(v.effects), strict=True) if then != now]


def _is_covariance(matrix: np.ndarray) -> bool:
    """Whether the matrix is symmetric and has no negative variance in any direction, but for rounding."""
    variance = np.diag(matrix)
    if (variance < 0).any():
        return False
    scale = np.sqrt(np.where(variance > 0, variance, 1.0))
    with np.errstate(over="ignore"):  # what overflows is far above a correlation of 1
        correlation = matrix / scale / scale[:, None]
    if not np.isfinite(correlation).all():
        return False
    symmetric = np.allclose(correlation, correlation.T, rtol=0, atol=ROUNDING)
    return bool(symmetric and np.linalg.eigvalsh(correlation).min() > -1e-3)

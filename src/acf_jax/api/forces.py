"""Peak forces of a model at contact velocities and pretensions."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import ArrayLike
from numpy.typing import NDArray

from acf_jax.api._values import check, warn
from acf_jax.api.source import ModelLike, Source, source_of
from acf_jax.contact.learnt import ask
from acf_jax.contact.peak import RIG, Trained
from acf_jax.errors import InputError
from acf_jax.gap_model import Which
from acf_jax.model import Impact, Rig, find_peaks
from acf_jax.predict import notes as notes_of
from acf_jax.predict import predict

Values = NDArray[np.float64]
MOST = 20  # impacts that are shown one by one
TOLD = 3  # notes


@dataclass(frozen=True, repr=False, eq=False)
class Forces:
    """Peak forces of impacts; fields have one shape, () for one impact. NaN: the model tells none there."""

    v: Values  # m/s, contact velocity
    f_p: Values  # N, pretension
    force: Values  # N, peak of the force at the contact; judge safety by it
    std: Values | None  # N, its standard deviation: parameters, explanations, form; None: not known
    time: Values  # s after first contact, of the peak; of a diagnosis' model as the sensor sees it
    sensed: Values | None = None  # N, peak of what the sensor reads; None: the model has no sensor
    sensed_std: Values | None = None  # N
    error_bound: Values | None = None  # N, by which a surrogate may be wrong
    notes: tuple[str, ...] = ()  # what takes from the answer

    def __float__(self) -> float:
        return float(self.force)

    def __repr__(self) -> str:
        columns = [np.ravel(x) for x in np.broadcast_arrays(self.v, self.f_p, self.force, self.time)]
        spread = "" if self.std is None else " ± standard deviation"
        lines = [f"contact velocity  pretension     peak force{spread}      after"]
        for i, (v, f_p, force, time) in enumerate(zip(*columns, strict=True)):
            std = "" if self.std is None else f" ± {np.ravel(self.std)[i]:.2g}"
            told = f"{force:10.2f}{std} N  {1e3 * time:9.3f} ms" if np.isfinite(force) else "none"
            lines.append(f"{v:12.4g} m/s  {f_p:8.4g} N   {told}")
        if len(lines) > MOST + 1:
            lines[MOST + 1 :] = [f"... and {len(lines) - MOST - 1} more"]
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])


def peak(model: ModelLike, v: ArrayLike, f_p: ArrayLike, which: Which | None = None) -> Forces:
    """Peak contact forces at contact velocities and pretensions.

    A diagnosis answers by its corrected model, simulated, or by the recalibrated one where the correction is known to
    be no better; a rig by the paper's model; a surrogate by its network.

    **Arguments:** `v`: contact velocity, m/s. `f_p`: pretension, N. Numbers or arrays, which broadcast. `which`: of a
    diagnosis `nominal`, `recalibrated` or `corrected`.

    **Returns:** `Forces` of the shape that `v` and `f_p` broadcast to.

    **Raises:** `InputError` for numbers that cannot be. **Warns** where the model extrapolates, where the data did not
    suffice for it, and where a correction is not shown to be better.

    >>> import acf_jax as acf
    >>> acf.read_model("examples/rig_model.json").peak([0.1, 0.3], 60.0)
    """
    source = source_of(model)
    check("peak", v_e=v, f_p=f_p)
    velocities, pretensions = _broadcast(v, f_p)
    if not velocities.size:
        raise InputError("v and f_p hold no impact; give one at least")
    if which is not None and (source.gap is None or source.trained is not None):
        raise InputError("which: only a diagnosis has several models; leave it out")
    if which not in (None, "nominal", "recalibrated", "corrected"):
        raise InputError(f"which: must be nominal, recalibrated or corrected, but is {which!r}; correct it")
    if source.trained is not None:
        found, notes = _learnt(source, velocities.ravel(), pretensions.ravel())
    elif source.gap is not None:
        found, notes = _predicted(source, velocities.ravel(), pretensions.ravel(), which)
    else:
        found, notes = _exact(source, velocities.ravel(), pretensions.ravel())
    columns = {"v": velocities, "f_p": pretensions} | found
    shaped = {name: None if x is None else np.reshape(x, velocities.shape)[()] for name, x in columns.items()}
    if len(notes) > TOLD:
        notes[TOLD:] = [f"and {len(notes) - TOLD} more such notes"]
    warn(notes)
    return Forces(**shaped, notes=tuple(notes))


Found = tuple[dict[str, Any], list[str]]


def _predicted(source: Source, v: Values, f_p: Values, which: Which | None) -> Found:
    assert source.gap is not None
    found = predict(source.gap, v, f_p, which)
    notes = notes_of(source.gap, v, f_p, which)
    if away := [f"{p_v:g} m/s, {p_f:g} N" for p_v, p_f, p in zip(v, f_p, found, strict=True) if p.diverges]:
        notes.append(f"the correction diverges at {away[0]}: what is told there is the recalibrated model's")
    fields = {
        "force": "contact_peak_force",
        "std": "contact_peak_force_std",
        "time": "peak_time",
        "sensed": "peak_force",
        "sensed_std": "peak_force_std",
    }
    return {name: np.array([getattr(p, of) for p in found]) for name, of in fields.items()}, notes


def _learnt(source: Source, v: Values, f_p: Values) -> Found:
    model = source.model
    assert isinstance(model.main.peak, Trained)
    points = [model.at(*at) for at in zip(v, f_p, strict=True)]
    found, faults = ask(model.main.peak, np.array(points))
    told = {"force": found.force, "time": found.time, "error_bound": found.error_bound}
    known = {name: np.where(found.is_inside, value, np.nan) for name, value in told.items()}
    answered = [z for z, inside in zip(points, found.is_inside, strict=True) if inside]
    return known | {"std": None}, [*dict.fromkeys(filter(None, faults)), *model.notes(*answered)]


def _exact(source: Source, v: Values, f_p: Values) -> Found:
    model = source.exact
    peaks = find_peaks(Rig(*model.main.theta[: len(RIG)]), Impact(v, f_p))
    told = {"force": peaks.f_max, "time": peaks.t_max}
    known = {name: np.where(peaks.has_peak, value, np.nan) for name, value in told.items()}
    notes = model.notes(*(model.at(*at) for at in zip(v, f_p, strict=True)))
    if not np.all(peaks.has_peak):
        notes.append(model.main.peak.no_peak)
    return known | {"std": None}, notes


def _broadcast(v: ArrayLike, f_p: ArrayLike) -> tuple[Values, Values]:
    try:
        one, other = np.broadcast_arrays(np.asarray(v, float), np.asarray(f_p, float))
    except ValueError:
        raise InputError(
            f"v and f_p must broadcast, but their shapes are {np.shape(v)} and {np.shape(f_p)}"
        ) from None
    return one.copy(), other.copy()

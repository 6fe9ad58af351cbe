"""What a gap model predicts at conditions that were not tried: traces, peaks and their uncertainty."""

from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np

from acf_jax.gap_model import GapModel, Variant, Which
from acf_jax.inference.forward import SAMPLES, Forces, Grid, forward, reach_of, step_for
from acf_jax.inference.interpolation import at_times, peak_of, phase_end
from acf_jax.inference.parameters import RIG, component_of, parameters

LONGEST = 0.060  # s, of a predicted trace whose contact is not lost
DIVERGED = 10.0  # times the largest force that the trials tried a free curve with,
BROKEN_DOWN = 1e6  # and N in any case


@dataclass(frozen=True)
class Prediction:
    """One impact. Traces run from time 0 until contact is lost and the sensor has seen it, or for 60 ms.

    `diverges`: a free curve does, far beyond the trials; the impact is predicted by the recalibrated model instead.
    """

    time: np.ndarray  # (n,) s
    force: np.ndarray  # (n,) N, what the sensor reads
    contact_force: np.ndarray  # (n,) N, what acts at the contact
    peak_force: float  # N, largest sample of `force`
    peak_force_std: float
    peak_time: float  # s
    contact_peak_force: float
    contact_peak_force_std: float
    diverges: bool = False


def predict(
    model: GapModel,
    v_e: np.ndarray,
    f_p: np.ndarray,
    which: Which | None = None,
    sample_rate: float | None = None,
) -> list[Prediction]:
    """Forces of impacts at the given conditions.

    **Arguments:** `v_e`, `f_p`: (trials,), m/s and N. `which`: the paper's model at the rig's prior values, refitted,
    or with the effects found; by default the last, unless it is known to be no better than the refitted one.
    `sample_rate`: Hz, the data set's by default.

    The standard deviation of a peak holds the uncertainty of the parameters, the spread between the explanations that
    still stand, and what the model missed on conditions that its fit did not see.

    **Returns:** one `Prediction` a trial.
    """
    which = which or model.preferred
    main: Variant = getattr(model, which)
    rate = sample_rate or model.sample_rate_hz
    others = model.alternatives if which == "corrected" else ()
    runs = [_run(model, v, v_e, f_p) for v in (main, *others)]
    weights = np.array([max(v.probability, 1e-9) for v in (main, *others)])
    weights /= weights.sum()
    mechanical = _without_sensor(main)
    unread = model.model_copy(update={"low_pass": None, "tool_mass_kg": None})
    is_read_as_is = mechanical.effects == main.effects and unread == model
    at_contact = runs[0] if is_read_as_is else _run(unread, mechanical, v_e, f_p)
    predictions = [_one(model, which, runs, at_contact, weights, i, rate) for i in range(len(v_e))]
    if which == "corrected" and runs[0].diverges.any():
        instead = predict(model, v_e, f_p, "recalibrated", sample_rate)
        predictions = [
            replace(other, diverges=True) if gone else own
            for own, other, gone in zip(predictions, instead, runs[0].diverges, strict=True)
        ]
    return predictions


def notes(model: GapModel, v_e: np.ndarray, f_p: np.ndarray, asked: Which | None = None) -> list[str]:
    """What a reader has to know of predictions at the given conditions before trusting them.

    **Arguments:** as `predict` takes them; `asked`: the model that was asked for, None where that was left open.
    """
    found = [_of_correction(model, asked)]
    if model.verdict == "insufficient_data" and asked not in ("nominal", "recalibrated"):
        found.append(
            "the diagnosis had too little data to tell a cause: take the correction as a fit to its trials"
        )
    tried = model.tried
    if beyond := [faults[0] for v, f in zip(v_e, f_p, strict=True) if (faults := tried.beyond(v, f))]:
        found.append(
            f"{len(beyond)} of {len(v_e)} impacts lie beyond the trials, where the model extrapolates; of the first,"
            f" {beyond[0]}"
        )
    return list(filter(None, found))


def _of_correction(model: GapModel, asked: Which | None) -> str:
    """What is known of the corrected model before trusting it, or before missing it."""
    if asked in ("nominal", "recalibrated"):
        return ""
    if model.better is False:
        used = "this is the recalibrated one's prediction" if asked is None else "take that one"
        return (
            "on conditions that the fit did not see the corrected model is not better than the recalibrated one;"
            f" {used}"
        )
    if model.shown_closer is False:
        return (
            "held-out conditions do not show that the corrected model comes closer than the recalibrated one;"
            " compare with the recalibrated model"
        )
    return ""


def tried_reach(model: GapModel, v: Variant) -> float:
    """The contact force, N, up to which the trials tried a variant's free curve; infinite where it has none."""
    tried = np.array(model.corners or tuple(product(model.v_range, model.f_p_range)))
    return reach_of(v.effects, np.array(v.theta), tried[:, 0], tried[:, 1], _grid(model, v))


def _grid(model: GapModel, v: Variant) -> Grid:
    h = max(min(model.step_s, step_for(*v.theta[: len(RIG)])), LONGEST / (SAMPLES - 4))
    low_pass = model.low_pass.filter if model.low_pass else None
    steps = min(int(LONGEST / h) + 3, SAMPLES - 1)
    return Grid(h, steps, low_pass=low_pass, tool_mass=model.tool_mass_kg)


class _Run(NamedTuple):
    """All impacts by one explanation."""

    forces: Forces
    grid: Grid
    covariance: np.ndarray
    delay: float  # s, of the reading
    diverges: np.ndarray  # (trials,) bool


def _run(model: GapModel, v: Variant, v_e: np.ndarray, f_p: np.ndarray) -> _Run:
    theta, grid = np.array(v.theta), _grid(model, v)
    reach = tried_reach(model, v)
    forces = forward(v.effects, theta, v_e, f_p, grid, reach)
    # a free curve that is continued far beyond the trials may diverge: from there on there is no force
    most = min(DIVERGED * reach, BROKEN_DOWN)
    with np.errstate(invalid="ignore"):
        sound = (np.abs(forces.sensed) < most) & (np.abs(forces.contact) < most)
    sound = np.logical_and.accumulate(sound, axis=1)
    forces = Forces(np.where(sound, forces.contact, 0.0), np.where(sound[:, None], forces.rows, 0.0))
    ends = [phase_end(s, c) for s, c in zip(forces.sensed, forces.contact, strict=True)]
    diverges = np.array([not all(ok[: end + 1]) for ok, end in zip(sound, ends, strict=True)])
    return _Run(forces, grid, np.array(v.covariance), v.delay_s, diverges)


def _without_sensor(v: Variant) -> Variant:
    """The same explanation without the sensor's effects, which leave the contact force as it is."""
    effects = tuple(name for name in v.effects if component_of(name) != "sensor")
    left = {name for name, _ in parameters(effects)}
    kept = [k for k, name in enumerate(v.names) if name in left]
    return v.model_copy(
        update={
            "effects": effects,
            "names": tuple(v.names[k] for k in kept),
            "theta": tuple(v.theta[k] for k in kept),
            "covariance": tuple(tuple(v.covariance[k][j] for j in kept) for k in kept),
            "delay_s": 0.0,
        }
    )


def _one(
    model: GapModel,
    which: Which,
    runs: list[_Run],
    at_contact: _Run,
    weights: np.ndarray,
    i: int,
    rate: float,
) -> Prediction:
    forces, grid, _, delay, _ = runs[0]
    end = min(LONGEST, (phase_end(forces.sensed[i], forces.contact[i]) - 1) * grid.h)
    time = np.arange(int(np.floor(end * rate + 1e-9)) + 1) / rate
    # when the sensor saw what it reads: at first contact it has seen nothing, however early it seemed to read
    read = np.where(time > 0, np.clip(time - delay, 0.0, grid.steps * grid.h), 0.0)

    def at(values: np.ndarray, when: np.ndarray) -> np.ndarray:
        return np.where(when == 0, values[0], at_times(values, when, grid.h, forces.contact[i]))

    force, contact = at(forces.sensed[i], read), np.maximum(at(forces.contact[i], time), 0.0)
    top = int(np.argmax(force))
    tops = [
        (peak_of(run.forces.sensed[i], run.grid.h, run.forces.contact[i]),
         peak_of(run.forces.contact[i], run.grid.h, run.forces.contact[i]))
        for run in runs
    ]  # fmt: skip
    peaks = np.array(tops)[:, :, 0]
    sound = weights * [not run.diverges[i] for run in runs]
    sound = sound / max(sound.sum(), 1e-9)
    between = sound @ (peaks - sound @ peaks) ** 2
    own, own_contact = _variance(runs[0], i, read[top]), _variance(at_contact, i, tops[0][1][1])
    form = model.form_error(which)
    sensed_peak, contact_peak = float(force[top]), tops[0][1][0]
    return Prediction(
        time=time,
        force=force,
        contact_force=contact,
        peak_force=sensed_peak,
        peak_force_std=float(np.sqrt(own + between[0] + (form * sensed_peak) ** 2)),
        peak_time=float(time[top]),
        contact_peak_force=contact_peak,
        contact_peak_force_std=float(np.sqrt(own_contact + between[1] + (form * contact_peak) ** 2)),
    )


def _variance(run: _Run, i: int, time: float) -> float:
    """Of the force that impact i reads at a time, N^2, by the covariance of the parameters."""
    there = at_times(run.forces.tangents[i], np.array([time]), run.grid.h, run.forces.contact[i])
    slope = there[: len(run.covariance), 0]
    return max(0.0, float(slope @ run.covariance @ slope))

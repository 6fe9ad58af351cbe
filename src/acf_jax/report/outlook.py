"""What the corrected model says at the trials' conditions and between them, for the figures of the report."""

from dataclasses import dataclass

import numpy as np

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.diagnosis.results import gap_model
from acf_jax.gap_model import Which
from acf_jax.inference.forward import BLOCKS
from acf_jax.predict import Prediction, predict

MODELS: tuple[Which, ...] = ("nominal", "recalibrated", "corrected")
LEVELS = 4  # pretensions for which curves over velocity are drawn


@dataclass(frozen=True)
class Curves:
    """Predictions over contact velocity at one pretension."""

    f_p: float  # N
    v_e: np.ndarray  # (n,) m/s, over the tried range
    by_model: dict[str, list[Prediction]]


@dataclass(frozen=True)
class Outlook:
    """Predictions at the condition of each trial, and over velocity at the tried pretensions."""

    which: (
        Which  # the model that is told: the corrected one, unless it is not better than the recalibrated one
    )
    trials: dict[str, Prediction]  # by that model
    curves: tuple[Curves, ...]


def outlook(diagnosis: Diagnosis) -> Outlook:
    """Run the models that a diagnosis leaves."""
    d = diagnosis
    model = gap_model(d)
    trials = d.dataset.trials
    v_e = np.array([t.contact_velocity for t in trials])
    f_p = np.array([t.pretension for t in trials])
    at_trials = predict(model, v_e, f_p)

    levels = np.unique(f_p)
    levels = levels[np.unique(np.linspace(0, len(levels) - 1, min(len(levels), LEVELS)).round().astype(int))]
    # as many velocities as fill the block that is compiled for the trials
    each = max(6, -(-len(trials) // BLOCKS[0]) * BLOCKS[0] // len(levels))
    v_grid = np.linspace(v_e.min(), v_e.max(), each) if np.ptp(v_e) else v_e[:1]
    over_v, over_f = np.tile(v_grid, len(levels)), np.repeat(levels, len(v_grid))
    runs = {which: predict(model, over_v, over_f, which) for which in MODELS}
    curves = tuple(
        Curves(float(level), v_grid, {which: _part(run, k, len(v_grid)) for which, run in runs.items()})
        for k, level in enumerate(levels)
    )
    return Outlook(model.preferred, {t.name: p for t, p in zip(trials, at_trials, strict=True)}, curves)


def _part(run: list[Prediction], k: int, n: int) -> list[Prediction]:
    return run[k * n : (k + 1) * n]

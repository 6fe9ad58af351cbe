"""What one trial shows by itself: its approach, its impact, its faults."""

from dataclasses import dataclass

import numpy as np

from acf_jax.dataset.faults import trace_faults
from acf_jax.dataset.noise import Approach, look_at_approach, quantisation_step
from acf_jax.dataset.phase import ImpactPhase, find_impact
from acf_jax.dataset.trials import Trial


@dataclass(frozen=True)
class TrialQuality:
    """What one trial shows by itself and against the others."""

    name: str
    approach: Approach | None  # None: no trace, or too few samples before contact
    phase: ImpactPhase | None  # None: no trace, or no impact seen in it
    sample_rate: float | None  # Hz
    quantisation: float  # N, step of the force readings; 0: none seen
    trigger_offset: float | None  # s, against the other trials; > 0: the impact comes late
    faults: tuple[str, ...]  # why the trial is not to be trusted; empty for a healthy one


def assess(trial: Trial, impact_time: float, noise_std: float | None = None) -> TrialQuality:
    """Look at one trial by itself.

    **Arguments:** `trial`: the trial. `impact_time`: how long an impact lasts, roughly, s. `noise_std`: noise of
    one sample, N; None: taken from the approach.
    """
    trace = trial.trace
    if trace is None:
        return TrialQuality(trial.name, None, None, None, 0.0, None, ())
    approach = look_at_approach(trace)
    own = approach.noise_std if approach else 0.0
    std = own if noise_std is None else noise_std
    offset = approach.offset if approach else 0.0
    phase = find_impact(trace, std, impact_time, offset)
    rate = 1.0 / float(np.median(np.diff(trace.time)))
    faults = trace_faults(trial, phase, std, offset)
    return TrialQuality(
        trial.name, approach, phase, rate, quantisation_step(trace.force), None, tuple(faults)
    )

"""Where the gap lies: in which phase of the contact, and in which conditions."""

from dataclasses import dataclass

import numpy as np

from acf_jax.diagnosis.heldout import HeldOut
from acf_jax.inference.fit import Fit
from acf_jax.inference.forward import forward
from acf_jax.inference.interpolation import peak_of
from acf_jax.inference.observations import Observations

PHASES = {
    "onset": (0.0, 0.15),
    "rise": (0.15, 0.75),
    "peak": (0.75, 1.25),
    "release": (1.25, np.inf),
}  # of t_max


@dataclass(frozen=True)
class ConditionGap:
    """The gap at one condition."""

    v_e: float
    f_p: float
    excess_rms_n: float | None  # None where no trial has a trace
    share: float
    phases: dict[str, float]  # excess squared residual of each phase over that of all trials


@dataclass(frozen=True)
class GapMap:
    """Shares of the recalibrated model's excess squared residual."""

    phase: dict[str, float | None]
    conditions: tuple[ConditionGap, ...]


def gap_map(observations: Observations, recalibrated: Fit, held: HeldOut) -> GapMap:
    """Excess of squared residual over what no model can predict, by phase and condition, on held-out conditions."""
    o = observations
    forces = forward((), recalibrated.physical, o.v_e, o.f_p, recalibrated.grid)
    t_max = np.array(
        [peak_of(forces.sensed[i], recalibrated.grid.h, forces.contact[i])[1] for i in range(len(o.names))]
    )
    excess = np.where(o.traced, held.excess, 0.0)
    relative = o.time / np.maximum(t_max, 1e-9)[:, None]
    by_phase = {
        name: np.where((relative >= low) & (relative < high), excess, 0.0).sum(1)
        for name, (low, high) in PHASES.items()
    }
    total_phase = {name: max(0.0, float(values.sum())) for name, values in by_phase.items()}
    all_phases = sum(total_phase.values())
    if all_phases <= 0:
        phase: dict[str, float | None] = dict.fromkeys(PHASES)
    else:
        phase = {name: value / all_phases for name, value in total_phase.items()}
    # of peaks alone, what they miss; beside traces a peak says too little to compare
    peaks_alone = bool(o.peak_only.all())
    missed = np.nan_to_num((held.peak - held.measured_peak) ** 2)  # a lower bound tells no peak
    of_trial = missed if peaks_alone else excess.sum(1)
    groups = [np.flatnonzero(o.condition == c) for c in np.unique(o.condition)]
    total = sum(max(0.0, float(of_trial[here].sum())) for here in groups) or 1.0

    def at(here: np.ndarray) -> ConditionGap:
        value, samples = max(0.0, float(of_trial[here].sum())), int(o.traced[here].sum())
        rms = float(np.sqrt(value / samples)) if samples else None
        parts = {} if peaks_alone else by_phase
        shares = {name: max(0.0, float(part[here].sum())) / total for name, part in parts.items()}
        return ConditionGap(float(o.v_e[here[0]]), float(o.f_p[here[0]]), rms, value / total, shares)

    return GapMap(phase, tuple(map(at, groups)))

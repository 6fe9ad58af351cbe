"""Where the gap lies: in which phase of the contact, and in which conditions."""

from dataclasses import dataclass, replace

import numpy as np

from acf_jax.diagnosis.fit import Fit
from acf_jax.diagnosis.forward import forward
from acf_jax.diagnosis.observe import Observations
from acf_jax.diagnosis.sample import peak_of
from acf_jax.diagnosis.validate import HeldOut

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
    excess_rms_n: float | None  # None without traces
    share: float
    phases: dict[str, float]  # excess squared residual of each phase over that of all trials


@dataclass(frozen=True)
class GapMap:
    """Shares of the recalibrated model's excess squared residual."""

    phase: dict[str, float | None]
    conditions: tuple[ConditionGap, ...]


def gap_map(observations: Observations, recalibrated: Fit, held: HeldOut) -> GapMap:
    """Excess of squared residual over what no model can predict, by phase and condition, on unseen conditions."""
    o = observations
    forces = forward((), recalibrated.theta[:-1], o.v_e, o.f_p, recalibrated.grid)
    t_max = np.array(
        [peak_of(forces.sensed[i], recalibrated.grid.h, forces.contact[i])[1] for i in range(len(o.names))]
    )
    excess = np.where(o.traced, held.excess, 0.0)
    relative = o.time / np.maximum(t_max, 1e-9)[:, None]
    by_phase = {
        name: np.where((relative >= low) & (relative < high), excess, 0.0).sum(1)
        for name, (low, high) in PHASES.items()
    }
    if o.peak_only.all():
        squared = (held.peak - held.measured_peak) ** 2
        rows = [_condition(o, c, squared, None, {}) for c in np.unique(o.condition)]
        total = sum(row[1] for row in rows) or 1.0
        named = [_named(o, *row, total) for row in rows]
        return GapMap(dict.fromkeys(PHASES), tuple(replace(gap, excess_rms_n=None) for gap in named))
    total_phase = {name: max(0.0, float(values.sum())) for name, values in by_phase.items()}
    all_phases = sum(total_phase.values())
    if all_phases <= 0:
        phase: dict[str, float | None] = dict.fromkeys(PHASES)
    else:
        phase = {name: value / all_phases for name, value in total_phase.items()}
    rows = [_condition(o, c, excess.sum(1), o.used.sum(1), by_phase) for c in np.unique(o.condition)]
    total = sum(max(0.0, row[1]) for row in rows) or 1.0
    return GapMap(phase, tuple(_named(o, *row, total) for row in rows))


def _condition(
    o: Observations,
    condition: int,
    excess: np.ndarray,
    samples: np.ndarray | None,
    by_phase: dict[str, np.ndarray],
) -> tuple[int, float, float, dict[str, float]]:
    here = o.condition == condition
    count = here.sum() if samples is None else samples[here].sum()
    value = float(excess[here].sum())
    rms = float(np.sqrt(max(0.0, value) / max(count, 1)))
    return condition, value, rms, {name: float(values[here].sum()) for name, values in by_phase.items()}


def _named(
    o: Observations, condition: int, value: float, rms: float, phases: dict[str, float], total: float
) -> ConditionGap:
    first = int(np.flatnonzero(o.condition == condition)[0])
    shares = {name: max(0.0, part) / total for name, part in phases.items()}
    return ConditionGap(float(o.v_e[first]), float(o.f_p[first]), rms, max(0.0, value) / total, shares)

"""What one trial shows by itself: its approach, its impact, its faults."""

from dataclasses import dataclass, replace

import numpy as np

from acf_jax.dataset.faults import Readings, cut_off, dropout, no_impact, stuck
from acf_jax.dataset.noise import Approach, look_at_approach, quantisation_step
from acf_jax.dataset.phase import ImpactPhase, find_impact
from acf_jax.dataset.trials import GapDataset, Trace, Trial
from acf_jax.dataset.units import expected_peak

LEAST = 6  # samples of an impact: a handful has no shape to judge
DIFFERS = 1.1  # times the force of one condition, of another one: too much for peaks that are equal by chance
BELOW = 3.0  # standard deviations of the noise, by which a reading at the range's end may lie below it
CUT_OFF = "its force is cut off at"


@dataclass(frozen=True)
class TrialQuality:
    """What one trial shows by itself and against the others."""

    name: str
    approach: Approach | None  # None: no trace, or too few samples before contact
    phase: ImpactPhase | None  # None: no trace, or no impact seen in it
    sample_rate: float | None  # Hz
    quantisation: float  # N, step of the force readings; 0: none seen
    trigger_offset: float | None  # s, against the other trials; > 0: the impact comes late
    tells_nothing: bool = False  # whether there is nothing to compare: no impact
    at_range: bool = False  # whether it reads as much as the range that is stated
    peak_is_bound: bool = (
        False  # whether its peak, without a trace, is a lower bound: the sensor's range ends there
    )
    faults: tuple[str, ...] = ()  # why the trial is not to be trusted; empty for a healthy one
    oddities: tuple[
        str, ...
    ] = ()  # what is strange about its shape: a fault unless its repeats have the same


def assess(
    trial: Trial, impact_time: float, noise_std: float | None = None, range_n: float = np.inf
) -> TrialQuality:
    """Look at one trial by itself.

    **Arguments:** `trial`: the trial. `impact_time`: how long an impact lasts, roughly, s. `noise_std`: noise of
    one sample, N; None: taken from the approach. `range_n`: reading at which the sensor's range ends, N.
    """
    trace = trial.trace
    if trace is None:
        end = range_n - BELOW * (noise_std or 0.0)
        is_bound = trial.peak_force is not None and trial.peak_force >= end
        return TrialQuality(
            trial.name, None, None, None, 0.0, None, at_range=is_bound, peak_is_bound=is_bound
        )
    approach = look_at_approach(trace)
    own = approach.noise_std if approach else 0.0
    std = own if noise_std is None else noise_std
    offset = approach.offset if approach else 0.0
    phase = find_impact(trace, std, impact_time, offset)
    rate = 1.0 / trace.step
    found = TrialQuality(trial.name, approach, phase, rate, quantisation_step(trace.force), None)
    if faults := no_impact(trial, phase):
        return replace(found, tells_nothing=True, faults=tuple(faults))
    assert phase is not None
    if phase.peak_force >= (end := range_n - BELOW * std):
        phase = replace(phase, cut_off=end)
        found = replace(found, phase=phase, at_range=True)
    if phase.stop - phase.start < LEAST:
        return found
    zeroed = Trace(trace.time, trace.force - offset)
    readings = Readings.of(trace.force, found.quantisation)
    sticking, falling = stuck(zeroed, phase, std, readings), dropout(zeroed, phase, std)
    if not found.at_range and cut_off(zeroed, phase, std, readings):
        phase = replace(phase, cut_off=phase.peak_force)
    return replace(
        found,
        phase=phase,
        faults=(sticking,) if sticking else (),
        oddities=(falling,) if falling else (),
    )


def at_one_ceiling(dataset: GapDataset, trials: list[TrialQuality]) -> list[TrialQuality]:
    """The trials that reach the reading at which several are cut off and none reads more: there the range ends for all.

    A trial that is cut off below what another one reads is faulty: the range is the same for all.
    """
    cut = {i: t.phase for i, t in enumerate(trials) if t.phase and t.phase.cut_off is not None}
    tops = {i: float(t.trace.force.max()) for i, t in enumerate(dataset.trials) if t.trace}
    highest = max(tops.values(), default=0.0)
    found = list(trials)
    if sum(phase.cut_off == highest for phase in cut.values()) >= 2:
        for i, t in enumerate(trials):
            if t.phase and t.phase.peak_force == highest:
                found[i] = replace(t, phase=replace(t.phase, cut_off=highest))
    for i, phase in cut.items():
        if phase.peak_force < highest and not found[i].at_range:
            fault = f"{CUT_OFF} {phase.peak_force:.4g} N, which other trials exceed (amplifier?)"
            found[i] = replace(found[i], faults=(*found[i].faults, fault))
    return _peaks_at_one_ceiling(dataset, found)


def _peaks_at_one_ceiling(dataset: GapDataset, trials: list[TrialQuality]) -> list[TrialQuality]:
    """Without traces: the largest peaks are the range's end where conditions that differ have them to the digit."""
    peaks = {
        i: t.peak_force for i, t in enumerate(dataset.trials) if t.trace is None and t.peak_force is not None
    }
    highest = max(peaks.values(), default=0.0)
    at_it = [i for i, peak in peaks.items() if peak == highest]
    expected = [expected_peak(dataset.rig, dataset.trials[i]) for i in at_it]
    if len(at_it) < 3 or max(expected) < DIFFERS * min(expected):
        return trials
    return [replace(t, peak_is_bound=True) if i in at_it else t for i, t in enumerate(trials)]

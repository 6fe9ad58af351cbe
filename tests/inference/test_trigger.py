"""The scatter of triggers, told from repeats whose trigger times are known."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from acf_jax.dataset import Measurement
from acf_jax.diagnosis.plan import imagine
from acf_jax.inference.fit import fit
from acf_jax.inference.forward import Grid, forward
from acf_jax.inference.interpolation import at_times, peak_of
from acf_jax.inference.observations import TRIGGER
from acf_jax.inference.parameters import begin
from acf_jax.inference.trigger import trigger_scatter
from tests.imagined import CONDITIONS, RATE
from tests.repeated import INTERVAL, NOISE, RIG, repeated


@pytest.mark.parametrize("scatter", [0.1, 0.3])
def test_a_scatter_is_found_and_not_understated(scatter: float) -> None:
    assert scatter < trigger_scatter(repeated(scatter)) < 1.7 * scatter


def test_repeats_that_do_not_repeat_say_nothing_of_triggers() -> None:
    """Those of one condition alone had made the scatter of all as large as it can be."""
    exact = repeated(0.0)
    force = exact.force.copy()
    force[0] = np.roll(force[0], 8)  # another impact altogether
    assert trigger_scatter(replace(exact, force=force)) < 0.1


def test_exact_triggers_are_known_to_be_exact() -> None:
    assert trigger_scatter(repeated(0.0)) < 0.1


def test_without_repeats_the_largest_scatter_stands() -> None:
    assert trigger_scatter(repeated(0.0, conditions=12, repeats=1)) == TRIGGER


def test_repeats_whose_samples_lie_between_each_others_are_compared_at_the_same_times() -> None:
    """A time that is off by 0.4 samples is seen; one by which samples begin later is not one of the trigger."""
    o = repeated(0.0)
    late = np.where(np.arange(len(o.names)) % 3 == 0, 0.4, 0.0)[:, None] * INTERVAL
    assert trigger_scatter(replace(o, time=o.time + late)) > 0.2
    shifted = [CubicSpline(t, f)(t + by) for t, f, by in zip(o.time, o.force, late[:, 0], strict=True)]
    assert trigger_scatter(replace(o, time=o.time + late, force=np.array(shifted))) < 0.1


def test_a_recording_may_begin_some_samples_later() -> None:
    o = repeated(0.3)
    begins = np.where(np.arange(len(o.names)) % 3 == 1, 2, 0)
    time = np.array([np.roll(t, -k) for t, k in zip(o.time, begins, strict=True)])
    force = np.array([np.roll(f, -k) for f, k in zip(o.force, begins, strict=True)])
    used = o.used & (np.arange(o.time.shape[1]) < o.time.shape[1] - begins[:, None])
    late = replace(o, time=time, force=force, used=used)
    assert 0.3 < trigger_scatter(late) < 1.7 * 0.3


def test_a_faulty_repeat_does_not_make_triggers_look_exact() -> None:
    o = repeated(0.3)
    force = o.force.copy()
    force[4] *= 0.5
    assert trigger_scatter(replace(o, force=force)) > 0.3


def test_a_delay_that_all_triggers_share_is_found_beside_many_peaks() -> None:
    """Peaks have no sampling interval: with theirs as the usual one, the delay looked like a lag of the sensor."""
    plain = replace(imagine(RIG, Measurement(), CONDITIONS, RATE, NOISE), trigger_std=0.02)
    grid, late = Grid(2e-5, 1000), 0.2 / RATE
    forces = forward((), RIG.values, plain.v_e, plain.f_p, grid)
    readings = np.array(
        [
            at_times(f, t - late, grid.h, c)
            for f, t, c in zip(forces.sensed, plain.time, forces.contact, strict=True)
        ]
    )
    peak_only = np.arange(len(plain.names)) < 8
    readings[peak_only, 0] = [
        peak_of(f, grid.h, c)[0]
        for f, c in zip(forces.sensed[peak_only], forces.contact[peak_only], strict=True)
    ]
    first = np.arange(readings.shape[1]) == 0
    observations = replace(
        plain,
        force=readings,
        used=plain.used & (first | ~peak_only[:, None]),
        peak_only=peak_only,
        interval=np.where(peak_only, 0.0, plain.interval),
    )
    found = fit(observations, (), begin(RIG.values))
    assert 0.5 * late < found.theta[-1] < 1.5 * late

"""How large each law of an explanation is."""

from dataclasses import replace

import numpy as np
import pytest

from acf_jax.inference.changes import changes
from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.parameters import begin
from tests.imagined import RIG, imagined

LAWS = ("gravity", "sensor_scale")


def _at(laws: tuple[str, ...], *strengths: list[float]) -> Fit:
    o = imagined(LAWS, (12.0, 0.04))
    return fit(o, laws, begin(RIG.values, *strengths), warm=True, iterations=0)


def test_a_gain_error_changes_its_share_of_the_force() -> None:
    """Where the fits without a law are no better than switching it off."""
    both = _at(LAWS, [12.0], [0.04])
    gravity, gain = changes(both, [_at(("sensor_scale",), [0.04]), _at(("gravity",), [12.0])])
    o = both.observations
    rms = float(np.sqrt((o.force[o.used] ** 2).mean()))
    assert gain == pytest.approx(0.04 / 1.04 * rms, rel=1e-3)
    assert 1.0 < gravity < 12.0


def test_what_refitting_makes_of_the_rest_counts_where_it_changes_more() -> None:
    """Without gravity the rig is taken far from where it was."""
    both, rest = _at(LAWS, [12.0], [0.04]), _at(("sensor_scale",), [0.04])
    usual, _ = changes(both, [rest, _at(("gravity",), [12.0])])
    astray = replace(rest, u=rest.u + np.array([0.0, 0.0, 0.0, 5.0, *rest.u[4:] * 0]))
    far, _ = changes(both, [astray, _at(("gravity",), [12.0])])
    assert far > 2 * usual


def test_a_lag_changes_what_it_does_from_first_contact_on() -> None:
    """Not what its triggers, fitted late, would make of the step of the force without it."""
    o = imagined(("sensor_lag",), (2e-5, 0.8))
    lagging = fit(o, ("sensor_lag",), begin(RIG.values, [2e-5, 0.8]), warm=True, iterations=0)
    (lag,) = changes(lagging, [fit(o, (), begin(RIG.values), warm=True, iterations=0)])
    slope = float(np.abs(np.gradient(o.force, axis=1)[o.used]).max() / o.interval[0])
    assert 0 < lag < 2 * 0.8 * 2e-5 * slope

"""What `plan` says of trials before they are made."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from acf_jax.dataset import LowPass, Measurement, Noise
from acf_jax.diagnosis import identifiability
from acf_jax.diagnosis.candidates import fit_nominal
from acf_jax.diagnosis.identifiability import Pair, stated
from acf_jax.diagnosis.plan import imagine, plan
from acf_jax.effects import library
from acf_jax.evidence.marginal import Marginal
from acf_jax.evidence.posterior import posterior
from acf_jax.inference.fit import fit
from acf_jax.inference.parameters import Explanation, begin, every_effect
from tests.imagined import CONDITIONS, NOISE, RATE, RIG, imagined


def test_an_effect_that_shows_by_its_second_strength_only_is_seen_with_both() -> None:
    """Peaks alone say nothing of an end stop's share, but of what opposes the motion afterwards."""
    kept = {name: library()[name] for name in ("end_stop", "sensor_scale", "pad_mass")}
    traced = imagine(RIG, Measurement(), CONDITIONS, RATE, NOISE)
    peaks = replace(
        traced,
        time=np.zeros((len(CONDITIONS), 1)),
        force=traced.force.max(1, keepdims=True),
        used=np.ones((len(CONDITIONS), 1), bool),
        peak_only=np.ones(len(CONDITIONS), bool),
        interval=np.zeros(len(CONDITIONS)),
    )
    nominal = fit(peaks, (), begin(RIG.values), warm=True, iterations=0)
    found = {d.effect: d for d in identifiability.detectability(peaks, nominal, list(kept))}
    stop = found["end_stop"]
    assert stop.smallest is not None and 0 < stop.smallest < 1 and stop.distance_at_typical > 3
    assert stop.smallest == pytest.approx(3 * 0.5 / stop.distance_at_typical)
    for d in found.values():
        assert d.smallest is None or d.smallest <= kept[d.effect].parameters()[0].high
    quiet = replace(peaks, noise=Noise(1e4))
    nominal = fit(quiet, (), begin(RIG.values), warm=True, iterations=0)
    hidden = identifiability.detectability(quiet, nominal, list(kept))
    assert all(d.smallest is None for d in hidden), "beyond all ranges"


def test_the_smallest_size_leaves_about_three_standard_deviations() -> None:
    smallest = {d.effect: d.smallest for d in plan(RIG, Measurement(), CONDITIONS, RATE, NOISE)}
    for effect in ("gravity", "contact_hardening", "sensor_scale"):
        size, *others = every_effect()[effect].parameters()
        parameters = (smallest[effect], *(p.starts[0] if p.shape else 0.0 for p in others))
        left = 2 * fit_nominal(imagined(effect, parameters)).objective
        assert 1.5 < np.sqrt(left) < 6.0, size.name  # linear from a start that may be much larger


def test_what_is_planned_ends_at_the_range_and_lies_behind_the_filter() -> None:
    def smallest(**measured: Any) -> dict[str, float]:
        found = plan(RIG, Measurement(**measured), CONDITIONS, RATE, NOISE)
        return {d.effect: np.inf if d.smallest is None else d.smallest for d in found}

    free, wide = smallest(), smallest(range_n=1e4)
    assert wide == pytest.approx(free)
    cut = smallest(range_n=60.0)  # of pretensions up to 120 N and peaks up to 280 N
    assert all(
        cut[name] > 1.5 * free[name] for name in ("pad_bottoming", "contact_hardening", "sensor_resonance")
    )
    slow = smallest(low_pass=LowPass(150.0, 4))
    # one sample in thirty is left, and next to nothing of a ring at several hundred hertz
    assert np.sqrt(30) < slow["gravity"] / free["gravity"] < 30
    assert slow["sensor_resonance"] / free["sensor_resonance"] > 4 * slow["gravity"] / free["gravity"]


def test_pairs_are_stated_by_the_laws_that_matter() -> None:
    """Two that differ in a small law alone are one pair, with the error of those that are confused most."""
    laws: dict[Explanation, tuple[float, ...]] = {
        ("gravity", "sensor_lag"): (20.0, 1.0),
        ("coulomb_friction", "sensor_lag"): (20.0, 1.0),
        ("coulomb_friction", "sensor_scale"): (20.0, 1.0),
    }
    told = posterior([Marginal(e, 0.0, 0.0, 0.0, changes) for e, changes in laws.items()])
    first, second, third = laws
    (pair,) = stated([Pair((first, second), 0.4), Pair((first, third), 0.2)], told)
    assert pair == Pair((("gravity",), ("coulomb_friction",)), 0.4)

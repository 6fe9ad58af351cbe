"""The gap by frequency: its squares add up, and a ring stands where it is."""

from dataclasses import replace

import numpy as np
import pytest

from acf_jax.diagnosis.spectrum import spectrum
from tests.repeated import INTERVAL, NOISE, repeated


def test_the_squares_of_all_bands_add_up() -> None:
    o = repeated(0.0)
    residual = np.random.default_rng(0).standard_normal(o.force.shape) + 3.0
    o = replace(o, used=np.arange(o.force.shape[1]) < np.arange(15, 39)[:, None])
    found = spectrum(o, {"corrected": np.where(o.used, residual, 0.0)})
    assert found is not None
    assert (found.gap["corrected"] ** 2).sum() == pytest.approx((residual[o.used] ** 2).mean())
    assert (
        found.edges[-1] == pytest.approx(0.5 / INTERVAL)
        and len(found.edges) == len(found.gap["corrected"]) + 1
    )


def test_what_repeats_do_not_share_stands_at_its_frequency() -> None:
    o = repeated(0.0)
    phase = 2 * np.pi * np.random.default_rng(0).random((len(o.names), 1))
    found = spectrum(replace(o, force=o.force + 20 * np.cos(2 * np.pi * 900 * o.time + phase)), {})
    assert found is not None and found.scatter is not None
    k = int(found.scatter.argmax())
    assert found.edges[k] / 1.1 < 900 < found.edges[k + 1] * 1.1
    assert found.scatter[k] == pytest.approx(20 / np.sqrt(2), rel=0.2)
    quiet = spectrum(o, {})
    assert quiet is not None and quiet.scatter is not None
    assert np.sqrt((quiet.scatter**2).sum()) < 5 * NOISE


def test_without_repeats_or_traces_there_is_nothing_to_show() -> None:
    alone = repeated(0.0, conditions=8, repeats=1)
    found = spectrum(alone, {"corrected": alone.force})
    assert found is not None and found.scatter is None
    assert spectrum(replace(alone, peak_only=np.ones(8, bool)), {}) is None

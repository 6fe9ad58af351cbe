"""What `plan` says of trials before they are made."""

import numpy as np

from acf_jax.dataset import Measurement
from acf_jax.diagnosis.candidates import fit_nominal
from acf_jax.diagnosis.plan import plan
from acf_jax.diagnosis.space import every_effect
from tests.diagnosis.imagined import CONDITIONS, NOISE, RATE, RIG, imagined


def test_the_smallest_size_leaves_about_three_standard_deviations() -> None:
    smallest = {d.effect: d.smallest for d in plan(RIG, Measurement(), CONDITIONS, RATE, NOISE)}
    for effect in ("gravity", "contact_hardening", "sensor_scale"):
        size, *others = every_effect()[effect].parameters()
        own = (smallest[effect], *(p.starts[0] if p.shape else 0.0 for p in others))
        left = 2 * fit_nominal(imagined(effect, own)).objective
        assert 1.5 < np.sqrt(left) < 6.0, size.name  # linear from a start that may be much larger

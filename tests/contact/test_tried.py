"""What was tried, as numbers are read."""

import pytest

from acf_jax.contact.tried import Tried

TRIED = Tried((0.05004, 0.3493), (50.0, 90.0), ((0.05004, 50.0), (0.3493, 50.0), (0.05004, 90.0)))


@pytest.mark.parametrize("v_e, f_p, says", [
    (0.05, 60.0, None),  # the trials' 0.05004 m/s reads 0.05
    (0.0499, 60.0, "v_e = 0.0499 m/s lies outside"),
    (0.349, 50.0, None),
    (0.3494, 49.98, None),  # between the trials at 50 N
    (0.351, 50.0, "v_e = 0.351 m/s lies outside"),
    (0.2, 49.0, "f_p = 49 N lies outside"),
    (0.2, 90.0, "but not together: with that pretension only 0.05004 to 0.05004 m/s"),
    (0.05, 90.04, None),
    (float("nan"), 60.0, "v_e = nan m/s lies outside"),
])  # fmt: skip
def test_what_reads_as_a_tried_value_was_tried(v_e, f_p, says):
    (found,) = TRIED.beyond(v_e, f_p) or ("",)
    assert says in found if says else not found

"""What was tried, as numbers are read."""

import pytest

from acf_jax.dataset.tried import Tried

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


@pytest.mark.parametrize("v_e, f_p, says", [
    (0.35, 50.0, None),  # the command of the trial that ran at 0.3493 m/s
    (0.3512, 50.0, None),
    (0.353, 50.0, "v_e = 0.353 m/s lies outside the tried 0.05004 to 0.3493 m/s"),
    (0.0498, 90.2, None),
    (0.0493, 60.0, "v_e = 0.0493 m/s lies outside"),
    (0.2, 91.0, "f_p = 91 N lies outside"),
    (0.06, 90.2, "but not together"),
])  # fmt: skip
def test_what_a_trial_at_the_end_was_told_was_tried(v_e, f_p, says):
    """Trials lie about what is commanded, by 0.25 % here."""
    (found,) = TRIED._replace(spread=(0.0025, 0.002)).beyond(v_e, f_p) or ("",)
    assert says in found if says else not found

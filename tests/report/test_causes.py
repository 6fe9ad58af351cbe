"""The figure of causes: what each curve is, against the closed form and against the prediction of the model."""

import json
import re

import numpy as np
import pytest

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.diagnosis.results import gap_model
from acf_jax.model import Impact, Rig, find_peak
from acf_jax.predict import predict
from acf_jax.report.causes import switched


def test_each_curve_is_the_model_with_those_causes(diagnosed: Diagnosis) -> None:
    html = switched(diagnosed)
    assert html is not None
    cause = diagnosed.corrected.explanation
    assert cause == ("coulomb_friction",)
    assert re.findall('data-cause="(.*?)"', html) == list(cause)
    figure = json.loads(re.search(r'id="causes-data">(.*?)</script>', html)[1])  # type: ignore[index]
    o = diagnosed.observations
    assert len(figure["variants"]) == len(o.names)
    m, d, k_f, k_c = diagnosed.corrected.physical[:4]
    told = predict(gap_model(diagnosed), o.v_e, o.f_p, "corrected")
    for i, variant in enumerate(figure["variants"]):
        lines = {tuple(t["meta"].get("causes", ["of"])): t for t in variant["data"] if "meta" in t}
        on, off, of = (np.array(lines[key]["y"], float) for key in (cause, (), ("of",)))
        assert lines[cause]["visible"] and not lines[()]["visible"]
        exact = find_peak(Rig(m, d, k_f, k_c), Impact(o.v_e[i], o.f_p[i]))
        assert off.max() == pytest.approx(float(exact.f_max), rel=2e-3)
        assert on.max() == pytest.approx(told[i].peak_force, rel=2e-3)
        np.testing.assert_allclose(of, on - off, atol=2e-2)


def test_nothing_is_switched_where_no_cause_is_in_the_model(
    peaks_only: Diagnosis, unknown: Diagnosis
) -> None:
    assert switched(peaks_only) is None  # no traces
    assert switched(unknown) is None  # a free curve

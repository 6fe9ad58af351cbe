"""The next trial is one at which both explanations say something."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from acf_jax.diagnosis import experiment
from acf_jax.diagnosis.candidates import fit_nominal
from acf_jax.diagnosis.fit import Linearisation
from tests.diagnosis.imagined import imagined


def test_no_trial_is_proposed_where_a_prediction_goes_astray(monkeypatch: pytest.MonkeyPatch) -> None:
    observations = imagined("gravity", (5.0,))
    fitted = fit_nominal(observations)
    other = replace(fitted, u=fitted.u + 0.5)
    plain = experiment.propose(observations, (fitted, 0.6), (other, 0.4))
    assert plain is not None
    linearise = experiment.linearise

    def astray_there(planned: Any, *rest: Any) -> Linearisation:
        found = linearise(planned, *rest)
        return replace(found, residual=1e9 * found.residual) if planned.v_e[0] > 0.9 * plain.v_e else found

    monkeypatch.setattr(experiment, "linearise", astray_there)
    elsewhere = experiment.propose(observations, (fitted, 0.6), (other, 0.4))
    assert elsewhere is not None and elsewhere.v_e <= 0.9 * plain.v_e
    assert np.isfinite(elsewhere.error_after)

"""What a diagnosis tells before it is done."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from acf_jax.dataset import GapDataset
from acf_jax.diagnosis import Diagnosis, diagnose
from acf_jax.diagnosis.explain import NEGLIGIBLE
from acf_jax.evidence.posterior import log_prior
from tests.diagnosis.conftest import CURVES, KEPT
from tests.few import few_explanations


def test_what_is_known_is_told_as_it_comes(gravity_set: GapDataset, diagnosed: Diagnosis) -> None:
    told: list[tuple[str, Any]] = []

    def watch(part: Mapping[str, Any]) -> None:
        json.dumps(part, allow_nan=False)
        told.extend(part.items())

    stages: list[int] = []
    with few_explanations(KEPT, CURVES):
        found = diagnose(gravity_set, progress=lambda stage: stages.append(len(told)), watch=watch)
    names = [name for name, _ in told]
    assert names[:3] == ["trust", "gap", "log_evidence"] and set(names) == set(names[:3])
    assert stages[0] == 0 and stages[1] == 1 and stages[2] >= 3  # before every effect is fitted
    assert told[0][1]["headline"] == found.quality.trust(found.excluded).headline
    gap = told[1][1]
    assert gap["nominal"]["force_rms_n"] == pytest.approx(found.gap["nominal"].force_rms_n, rel=1e-3)
    assert gap["recalibrated"]["force_rms_n"] < gap["nominal"]["force_rms_n"]
    tables = [value for name, value in told if name == "log_evidence"]
    counts = [len(table) for table in tables]
    assert counts[0] == 1 and counts[1:5] == [2, 3, 4, 5]  # one fit after the other
    values = [one["value"] for one in tables[-1]]
    assert values == sorted(values, reverse=True)
    best = {}
    for m in found.evidence:
        best[m.explanation] = max(best.get(m.explanation, -float("inf")), m.log_z)
    listed = {tuple(one["effects"]): one["value"] for one in tables[-1]}
    log_p = {e: value + log_prior(e) for e, value in listed.items()}
    negligible = {e for e in log_p if log_p[e] < max(log_p.values()) + np.log(NEGLIGIBLE)}
    assert set(best) <= listed.keys() <= set(best) | negligible  # of what is found beside one size alone
    first = tuple(tables[-1][0]["effects"])
    assert values[0] == pytest.approx(best[first] - best[()], abs=0.01)
    assert "probability" not in json.dumps([value for _, value in told])


@pytest.mark.long
def test_who_watches_changes_nothing(gravity_set: GapDataset, diagnosed: Diagnosis) -> None:
    with few_explanations(KEPT, CURVES):
        found = diagnose(gravity_set, watch=lambda part: None)
    assert found.probability == diagnosed.probability and found.verdict == diagnosed.verdict

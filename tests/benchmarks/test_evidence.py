"""A run's evidence survives being kept."""

import gzip

from acf_jax.diagnosis.score import UNKNOWN, WEIGHTS, Evidence
from benchmarks.evidence import Case, keep, read_cases
from benchmarks.fit_weights import component, explained, report

STRAIN = (0.0, 0.0, 0.0, 0.0)
FITS = [
    Evidence((), 5000.0, STRAIN, None),
    Evidence(("sensor_lag",), 1000.25, STRAIN, -2.5),
    Evidence(("unknown_contact",), 990.0, (1.5, 0.0, 0.0, 0.0), None),
]
KNOWN = Case("a", "clear", FITS, 1000, 0.05, frozenset({("sensor_lag",)}), frozenset({"sensor"}))
HIDDEN = KNOWN._replace(name="b", kind="unknown", right=frozenset({UNKNOWN}))


def test_kept_evidence_reads_as_it_was(tmp_path) -> None:
    for name in ("one.jsonl.gz", "two.jsonl.gz"):
        keep([KNOWN, HIDDEN], tmp_path / name)
    assert read_cases(tmp_path / "one.jsonl.gz") == [KNOWN, HIDDEN]
    assert (tmp_path / "one.jsonl.gz").read_bytes() == (tmp_path / "two.jsonl.gz").read_bytes()
    with gzip.open(tmp_path / "one.jsonl.gz") as lines:
        assert len(list(lines)) == 2


def test_a_report_tells_causes_and_components() -> None:
    assert max(explained(KNOWN, WEIGHTS).items(), key=lambda item: item[1])[0] == ("sensor_lag",)
    assert component(HIDDEN, WEIGHTS) == "sensor"
    assert "clear 1/1, unknown 0/1 (component 1)" in report("present", [KNOWN, HIDDEN], WEIGHTS)

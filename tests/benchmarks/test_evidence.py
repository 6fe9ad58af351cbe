"""A run's evidence survives being kept."""

import gzip
import json

import pytest

from acf_jax.evidence.posterior import UNKNOWN
from acf_jax.evidence.scores import WEIGHTS, Evidence
from benchmarks.evidence import Case, keep, read_cases
from benchmarks.fit_weights import component, explained, report

STRAIN = (0.0, 0.0, 0.0, 0.0)
FITS = [
    Evidence((), 5000.0, STRAIN, None),
    Evidence(("sensor_lag",), 1000.25, STRAIN, -2.5),
    Evidence(("unknown_contact",), 990.0, (1.5, 0.0, 0.0, 0.0), None, 31.25),
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


def test_a_run_says_by_its_score_what_counts_as_right(tmp_path) -> None:
    with pytest.raises(SystemExit, match="is not scored yet; finish `python -m acf_jax blind --out"):
        read_cases(tmp_path)
    with pytest.raises(SystemExit, match=r"other\.jsonl\.gz: no such file or folder; name a scored run"):
        read_cases(tmp_path / "other.jsonl.gz")
    known = {"set": "a", "kind": "single", "truth": ["sensor_lag"], "components": ["sensor"], "clear": True}
    known["neighbours"] = {}
    hidden = known | {"set": "b", "kind": "withheld", "truth": ["unknown"], "neighbours": {"gravity": 0.3}}
    among = known | {"set": "d", "kind": "lifelike", "background": ["gravity", "pad_mass"]}
    failed = {"set": "c", "error": "no trials"}
    fits = [
        {
            "effects": e.explanation,
            "chi_square": e.chi_square,
            "rig_strain": e.strain,
            "log_volume": e.volume,
            "optimism": e.optimism,
        }
        for e in FITS
    ]
    for name in "abd":
        (tmp_path / "results" / name).mkdir(parents=True)
        content = {"evidence": {"samples": 1000, "noise_doubt": 0.05, "fits": fits}}
        (tmp_path / "results" / name / "diagnosis.json").write_text(json.dumps(content))
    (tmp_path / "results/score.json").write_text(json.dumps({"rows": [known, hidden, failed, among]}))
    assert read_cases(tmp_path) == [
        KNOWN,
        HIDDEN._replace(right=frozenset({UNKNOWN, ("gravity",)})),
        KNOWN._replace(
            name="d",
            kind="lifelike",
            right=frozenset(
                {
                    ("sensor_lag",),
                    ("gravity", "sensor_lag"),
                    ("pad_mass", "sensor_lag"),
                    ("gravity", "pad_mass", "sensor_lag"),
                }
            ),
        ),
    ]


@pytest.mark.parametrize(
    "content",
    [b"words", gzip.compress(b"words"), gzip.compress(b'{"evidence": 1}\n')],
    ids=["text", "compressed text", "another list"],  # what is compressed holds the time of day
)
def test_a_file_of_something_else_is_named(content, tmp_path) -> None:
    (tmp_path / "one.jsonl.gz").write_bytes(content)
    with pytest.raises(SystemExit, match=r"one\.jsonl\.gz: holds no evidence; name a run's folder"):
        read_cases(tmp_path / "one.jsonl.gz")


def test_a_report_tells_causes_and_components() -> None:
    assert max(explained(KNOWN, WEIGHTS).items(), key=lambda item: item[1])[0] == ("sensor_lag",)
    assert component(HIDDEN, WEIGHTS) == "sensor"
    assert "clear 1/1, unknown 0/1 (component 1)" in report("present", [KNOWN, HIDDEN], WEIGHTS)

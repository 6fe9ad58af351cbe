"""A benchmark of measured causes: public recordings of impacts whose cause is known by design.

    python -m benchmarks.measured build --from COPIES --out SETS
    python -m benchmarks.measured score --sets SETS [--out RESULTS]

COPIES holds local copies of the public repositories that `rigs/` names, one folder each; nothing is downloaded, and no
recording is part of this repository. `answers.yaml` says what is known of each set and what counts as right. It was
frozen before the first diagnosis: `answers.sha256` is checked on every run.
"""

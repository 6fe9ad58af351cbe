#!/usr/bin/env bash
# Format, lint, types, tests and examples, in one command; needs `pip install ".[dev]"` once.
set -euo pipefail
cd "$(dirname "$0")"
ruff format --check .
ruff check .
mypy
# The README's test command, word for word (tests/test_package.py compares them).
pip install -q ".[test]" && python -m pytest -q "$@"

#!/usr/bin/env bash
# Format, lint, types, the documentation's site, tests and examples, in one command; needs `pip install ".[dev]"` once.
set -euo pipefail
cd "$(dirname "$0")"
ruff format --check .
ruff check .
mypy & types=$!
NO_MKDOCS_2_WARNING=1 mkdocs build -q --strict  # it imports what pip installs below
# The README's test command (tests/test_package.py compares them).
pip install -q ".[test]" && wait "$types" && python -m pytest -q "$@"

#!/usr/bin/env bash
# Format, lint, types, the documentation's site, tests and examples, in one command; needs `pip install ".[dev]"` once.
set -euo pipefail
cd "$(dirname "$0")"
ruff format --check .
ruff check .
mypy & types=$!
NO_MKDOCS_2_WARNING=1 mkdocs build --strict  # with -q it would count no warnings; it imports what pip installs below
wait "$types"
# The README's test command (tests/test_package.py compares them); a contributor's editable install stays as it is.
if [[ -n ${CI:-} ]]; then pip install -q ".[test]"; fi && python -m pytest -q "$@"
if (($# == 0)); then python -m pytest -q -m long; fi

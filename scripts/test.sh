#!/usr/bin/env bash
# Linters and tests, on a fresh machine; arguments go to pytest.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/environment.sh test
echo "haul_ros: ruff, mypy, import-linter"
ruff check .
ruff format --check .
mypy
lint-imports
exec python -m pytest "$@"

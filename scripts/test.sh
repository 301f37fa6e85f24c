#!/usr/bin/env bash
# Linters and tests, on a fresh machine; arguments go to pytest, which then measures no coverage.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/environment.sh test

check() {
    ruff check . && ruff format --check . && mypy && lint-imports
}
echo "haul_ros: ruff, mypy, import-linter"
if [ $# -gt 0 ]; then
    check
    exec python -m pytest "$@"
fi
# Compiled code leaves no trace: tests of short trains show what lines of the kernel are run
interpreted() {
    NUMBA_DISABLE_JIT=1 coverage run -m pytest -q -m interpreted tests/physics tests/simulation
}
coverage erase
(check && interpreted) & # on one core, while the other one compiles the model for all tests
python -m haul_ros run daqin_1_1_0 --set max_duration_s=1 --quiet
wait $!
exec python -m pytest -n 2 --dist loadgroup --no-loadscope-reorder --cov --cov-append --cov-report=term

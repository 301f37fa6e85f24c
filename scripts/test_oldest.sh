#!/usr/bin/env bash
# The quick tests with the oldest versions that setup.py allows, in an environment of their own; arguments go to pytest.
# They exist for Python 3.11 and 3.12.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/environment.sh test .venv-oldest scripts/oldest.txt
python -m pip check
# Each numba keeps its own machine code
export NUMBA_CACHE_DIR="$environment/numba"
python -m haul_ros run daqin_1_1_0 --set max_duration_s=1 --quiet
exec python -m pytest -q -n 2 --dist loadgroup -m "not slow" "$@"

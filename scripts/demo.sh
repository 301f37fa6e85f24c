#!/usr/bin/env bash
# The main job, live, on a fresh machine: see examples/emergency_stop.py.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/environment.sh ""
exec python examples/emergency_stop.py "$@"

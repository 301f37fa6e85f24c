#!/usr/bin/env bash
# Known vulnerabilities of what test.sh has installed: see audit.py.
set -euo pipefail
cd "$(dirname "$0")/.."
[ -x .venv-audit/bin/pip-audit ] || .venv/bin/python -m venv .venv-audit
.venv-audit/bin/python -m pip install --quiet --disable-pip-version-check 'pip-audit>=2.10,<3'
.venv/bin/python scripts/audit.py .venv-audit/bin/pip-audit "$(.venv/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')"

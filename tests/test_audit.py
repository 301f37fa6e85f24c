"""The audit of CI fails on a vulnerability, and never takes silence for health."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

AUDIT = Path(__file__).parents[1] / "scripts/audit.py"

# Answers as pip-audit does, of the package of which much is known and of the environment
STAND_IN = """#!{python}
import json, sys
about = {known!r} if "--requirement" in sys.argv else {environment!r}
if about is None:
    sys.exit("ERROR: Failed to resolve the name")
print(json.dumps({{"dependencies": about, "fixes": []}}))
sys.exit(any(d.get("vulns") for d in about))
"""
VULNERABLE = [{"name": "old", "version": "1.0", "vulns": [{"id": "PYSEC-1", "fix_versions": ["1.1"]}]}]
HEALTHY = [{"name": "new", "version": "2.0", "vulns": []}, {"name": "local", "skip_reason": "not found"}]
UNKNOWN = [{"name": "old", "skip_reason": "not found"}]


@pytest.mark.parametrize(
    ("known", "environment", "status", "told"),
    [
        (VULNERABLE, VULNERABLE, 1, "1 known vulnerabilities; not known to the service: none\n  old 1.0: PYSEC-1\n"),
        (VULNERABLE, HEALTHY, 0, "0 known vulnerabilities; not known to the service: local\n"),
        (VULNERABLE, None, 0, "NOTHING WAS AUDITED"),
        (UNKNOWN, HEALTHY, 0, "NOTHING WAS AUDITED"),
        (HEALTHY, HEALTHY, 0, "NOTHING WAS AUDITED"),
        (None, VULNERABLE, 0, "NOTHING WAS AUDITED"),
    ],
)
def test_what_is_found_fails_and_what_does_not_answer_is_told(
    tmp_path: Path, known: object, environment: object, status: int, told: str
) -> None:
    program = tmp_path / "pip-audit"
    program.write_text(STAND_IN.format(python=sys.executable, known=known, environment=environment), "utf-8")
    program.chmod(0o755)
    ended = subprocess.run([sys.executable, AUDIT, program, tmp_path], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (status, "")
    assert told in ended.stdout

"""Known vulnerabilities of what an environment holds: python scripts/audit.py PIP_AUDIT SITE_PACKAGES.

Status 1 where one is found. Where the service that knows them does not answer, this says so and ends with status 0.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

LONGEST = 180.0
"""Wall time [s] after which the service counts as not reachable."""

KNOWN = "urllib3==1.24.1"
"""Vulnerable in many ways: who finds nothing in it was told nothing."""


def ask(program: str, *arguments: str) -> tuple[list[str], list[str]] | None:
    """What pip-audit finds and what it could not ask about; None: it does not say."""
    command = [program, "--format", "json", "--progress-spinner", "off", "--timeout", "10", *arguments]
    try:
        ended = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST, check=False)
        dependencies = json.loads(ended.stdout)["dependencies"]
    except (subprocess.TimeoutExpired, json.JSONDecodeError):
        return None
    found = [f"{d['name']} {d['version']}: {v['id']}" for d in dependencies for v in d.get("vulns", [])]
    return found, [d["name"] for d in dependencies if "skip_reason" in d]


def main(program: str, site_packages: str) -> int:
    """Audit the packages in a folder."""
    with tempfile.TemporaryDirectory() as folder:
        known = Path(folder) / "known.txt"
        known.write_text(f"{KNOWN}\n", "utf-8")
        answers = ask(program, "--no-deps", "--disable-pip", "--requirement", str(known))
    audited = ask(program, "--skip-editable", "--path", site_packages) if answers and answers[0] else None
    if audited is None:
        print("audit: NOTHING WAS AUDITED: the service that knows vulnerabilities does not answer here")
        return 0
    found, skipped = audited
    print(f"audit: {len(found)} known vulnerabilities; not known to the service: {', '.join(skipped) or 'none'}")
    print("".join(f"  {line}\n" for line in found), end="")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))

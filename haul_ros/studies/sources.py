"""Which sources a result depends on."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

_ROOMS = ("model", "physics", "scenario", "simulation", "analysis", "studies", "units.py")
"""Parts of the package through which a scenario goes on its way to the result of a case."""


@cache
def results_digest(package: Path = Path(__file__).parents[1]) -> str:
    """Digest of all sources that make results, of a folder that holds the package: other sources, other results."""
    digest = hashlib.sha256()
    for room in _ROOMS:
        found = package / room
        for path in sorted(found.rglob("*.py")) if found.is_dir() else [found]:
            digest.update(f"{path.relative_to(package)}\n".encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()

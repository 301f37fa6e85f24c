"""The command line as a user meets it, in an empty folder with a short train."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from haul_ros.cli.main import main


@dataclass(frozen=True)
class Outcome:
    """How a command ended."""

    status: int
    out: str
    err: str


Haul = Callable[..., Outcome]


@pytest.fixture
def environment() -> dict[str, str]:
    """That of a Python process which takes haul_ros from here, wherever it is started."""
    path = os.pathsep.join(filter(None, [str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH")]))
    return os.environ | {"PYTHONPATH": path}


@pytest.fixture
def haul(short_train: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Haul:
    """Runs ``haul`` with arguments in a folder that holds ``short.yaml``."""
    (tmp_path / "short.yaml").write_text(short_train, "utf-8")
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> Outcome:
        try:
            status = main(arguments)
        except SystemExit as end:
            assert isinstance(end.code, int)
            status = end.code
        return Outcome(status, *capsys.readouterr())

    return run

"""A small train to alter, and a way to write it to a file."""

from collections.abc import Callable
from pathlib import Path

import pytest

SMALL_TRAIN = """\
consist:
  - {vehicle: SS4, role: master}
  - {vehicle: C80, count: 4}
  - {vehicle: SS4, role: slave}
coupler: paper_set_b
brakes: paper_set_b
initial_speed_kmh: 80
"""


@pytest.fixture
def small_train() -> str:
    """Seven lines: locomotive, four wagons, locomotive."""
    return SMALL_TRAIN


@pytest.fixture
def scenario_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], str]:
    """Writes ``my.yaml`` into an empty working directory and returns its name."""
    monkeypatch.chdir(tmp_path)

    def write(text: str) -> str:
        Path("my.yaml").write_text(text, "utf-8")
        return "my.yaml"

    return write

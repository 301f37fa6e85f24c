from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from tests.cli.conftest import Haul


@pytest.fixture
def recorded(haul: Haul) -> Haul:
    assert haul("run", "short.yaml", "-o", "run.mcap", "--quiet").status == 0
    return haul


def test_report_writes_one_file_and_overwrites_none(recorded: Haul) -> None:
    before = set(Path().iterdir())
    outcome = recorded("report", "run.mcap")
    assert (outcome.status, outcome.err) == (0, "")
    assert set(Path().iterdir()) - before == {Path("run.html")}
    written = Path("run.html").read_bytes()
    assert written.startswith(b"<!doctype html>")
    again = recorded("report", "run.mcap")
    assert (again.status, again.err) == (2, "haul: run.html: exists already, expected the name of a new file (-o)\n")
    assert Path("run.html").read_bytes() == written
    named = recorded("report", "run.mcap", "-o", "other.html", "--json")
    assert json.loads(named.out) == {"report": "other.html", "size_bytes": len(written)}
    assert Path("other.html").read_bytes() == written  # nothing of the time or the place of its making


def test_what_cannot_be_reported_leaves_no_file(recorded: Haul) -> None:
    Path("bad.mcap").write_bytes(bytes(8) + Path("run.mcap").read_bytes()[8:])
    for file, output in (("bad.mcap", "a.html"), ("missing.mcap", "a.html"), ("run.mcap", "no_folder/a.html")):
        outcome = recorded("report", file, "-o", output)
        assert outcome.status == 2
        assert len(outcome.err.splitlines()) == 1, outcome.err
        assert not Path(output).exists()

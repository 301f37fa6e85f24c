"""The pages: they build without a warning, lead nowhere that is not there, say what the code says, and run."""

from __future__ import annotations

import importlib
import inspect
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import haul_ros
from haul_ros.cli.command_page import command_page
from haul_ros.resources import config_dir
from haul_ros.scenario import load_scenario, load_scenario_text
from haul_ros.scenario.key_page import key_page
from tests.waiting import WAIT

ROOT = Path(__file__).parent.parent
PAGES = sorted((ROOT / "docs").rglob("*.md")) + sorted(ROOT.glob("*.md"))
TUTORIALS = sorted((ROOT / "docs/tutorials").glob("*.md"))
FENCE = re.compile(r"^```(\w*)\n(.*?)^```", re.M | re.S)


def blocks(page: str, language: str) -> list[str]:
    """Fenced blocks of a language, in order."""
    return [text for name, text in FENCE.findall((ROOT / page).read_text("utf-8")) if name == language]


@pytest.mark.slow
def test_the_site_builds_without_a_warning(tmp_path: Path) -> None:
    pytest.importorskip("sphinx")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", str(ROOT / "docs"), str(tmp_path / "site")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=WAIT)
    assert (done.returncode, done.stderr) == (0, "")
    python = (tmp_path / "site/python.html").read_text("utf-8")
    assert [name for name in haul_ros.__all__ if name != "__version__" and f'id="haul_ros.{name}"' not in python] == []


def test_every_page_is_in_the_table_of_contents() -> None:
    listed = {line.strip() for line in (ROOT / "docs/index.rst").read_text("utf-8").splitlines()}
    pages = {str(page.relative_to(ROOT / "docs").with_suffix("")) for page in (ROOT / "docs").rglob("*.md")}
    assert pages - listed == set()


def _slug(heading: str) -> str:
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_to_a_file_leads_somewhere(page: Path) -> None:
    text = FENCE.sub("", page.read_text("utf-8"))
    for target in re.findall(r"\]\((?!https?://|#)(.*?)\)", text):
        path, _, anchor = target.partition("#")
        found = page.parent / path
        assert found.is_file(), f"{page.name}: {target}"
        if anchor:
            headings = re.findall(r"^#+ (.*)$", FENCE.sub("", found.read_text("utf-8")), re.M)
            assert anchor in {_slug(heading) for heading in headings}, f"{page.name}: {target}"


@pytest.mark.parametrize(
    ("page", "text", "module"),
    [
        ("docs/commands.md", command_page(), "haul_ros.cli.command_page"),
        ("docs/scenario-keys.md", key_page(), "haul_ros.scenario.key_page"),
    ],
    ids=["commands", "keys"],
)
def test_the_page_is_the_one_that_the_code_makes(page: str, text: str, module: str) -> None:
    assert (ROOT / page).read_text("utf-8") == text, f"run: python -m {module}"


def test_the_scenario_of_the_page_loads() -> None:
    scenario = load_scenario_text(blocks("docs/scenarios.md", "yaml")[0], "page")
    assert len(scenario.consist.vehicles) == 208
    assert sum(gear is None for gear in scenario.consist.couplers) == 2 * 34


def test_the_line_of_the_page_loads(tmp_path: Path) -> None:
    (tmp_path / "line.csv").write_text(blocks("docs/scenarios.md", "csv")[0], encoding="utf-8")
    track = load_scenario("daqin_1_2_1", {"track.file": str(tmp_path / "line.csv")}).track
    assert track.grades == ((0.0, -0.004), (2000.0, -0.009))
    assert (track.curves, track.grade_ramp) == (((500.0, 1 / 800), (900.0, 0.0)), 200.0)


def test_the_python_of_the_pages_runs(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (simulate,), (read,) = blocks("docs/python.md", "python"), blocks("docs/recordings.md", "python")
    exec(simulate, {})
    force, tension = capsys.readouterr().out.splitlines()
    assert re.fullmatch(r"\d+\.\d+ kN", force)
    assert re.fullmatch(r"CouplerPeak\(value=\d+\..*", tension)

    session = haul_ros.Session(haul_ros.load_scenario("daqin_1_2_1"))
    encoder = haul_ros.TelemetryEncoder(session.consist)
    with haul_ros.McapRecorder(tmp_path / "run.mcap", session.scenario, encoder.channels) as recorder:
        recorder.put(encoder.messages(session.take_log()), 0)
    namespace: dict[str, object] = {}
    exec(read.replace("run.mcap", str(tmp_path / "run.mcap")), namespace)
    assert namespace["couplers"].force.shape == (1, 207)  # type: ignore[attr-defined]
    assert namespace["vehicles"].chainage.shape == (1, 208)  # type: ignore[attr-defined]
    assert namespace["largest"].compression.shape == (207,)  # type: ignore[attr-defined]


@pytest.mark.slow
@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_all_that_is_typed_in_a_tutorial_works(page: Path, tmp_path: Path) -> None:
    """Its files are written, its commands run one after the other, and none of them fails."""
    text = page.read_text("utf-8")
    script = ["set -euo pipefail"]
    for language, block in FENCE.findall(text):
        if language in ("python", "yaml"):
            name = re.match(r"# (\S+\.\w+)\n", block)
            assert name is not None, f"{page.name}: a file without a name"
            (tmp_path / name[1]).write_text(block, "utf-8")
        elif language == "bash":
            script.append(block)
    commands = "\n".join(script)
    if "haul node" in commands:
        pytest.importorskip("rclpy")
    from tests.ros.domain import own_domain

    done = subprocess.run(
        ["bash", "-c", commands],
        cwd=tmp_path,
        env={**os.environ, **own_domain(), "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        timeout=WAIT,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    left = {path.name for path in tmp_path.iterdir() if path.name.endswith(".active")}
    assert left == set()


def test_the_schemas_refer_only_to_what_they_have() -> None:
    """So that editors can follow them too, which read each file by itself."""
    import json

    schemas = {path.name: json.loads(path.read_text("utf-8")) for path in (config_dir() / "schema").glob("*.json")}
    for name, schema in schemas.items():
        for file, pointer in re.findall(r'"\$ref": "([\w.]*)#([^"]*)"', json.dumps(schema)):
            found = schemas[file or name]
            for part in filter(None, pointer.split("/")):
                assert part in found, f"{name}: {file}#{pointer}"
                found = found[part]


def test_python_in_the_analysis_document_runs(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    session = haul_ros.Session(haul_ros.load_scenario("daqin_1_1_0", {"max_duration_s": 3}), play_commands=True)
    encoder = haul_ros.TelemetryEncoder(session.consist)
    with haul_ros.McapRecorder(tmp_path / "run.mcap", session.scenario, encoder.channels) as recorder:
        while not session.finished:
            session.advance()
            recorder.put(encoder.messages(session.take_log()), 0)
    (code,) = blocks("docs/analysis.md", "python")
    exec(code.replace("run.mcap", str(tmp_path / "run.mcap")), {})
    force = float(capsys.readouterr().out.split()[0])
    assert force == pytest.approx(session.extremes().compression.max() / 1e3)


def test_functions_of_the_analysis_document_are_there() -> None:
    text = (ROOT / "docs" / "analysis.md").read_text("utf-8").split("| module of `haul_ros.analysis` |")[1]
    rows = re.findall(r"^\| `(\w+)` \| (.*) \|$", text, flags=re.M)
    assert len(rows) == 10
    for module, functions in rows:
        for name, arguments in re.findall(r"`(\w+)(\(.*?\))?`", functions):
            found = getattr(importlib.import_module(f"haul_ros.analysis.{module}"), name)
            if arguments:
                assert list(inspect.signature(found).parameters)[: arguments.count(",") + 1] == [
                    argument.strip() for argument in arguments.strip("()").split(",")
                ]

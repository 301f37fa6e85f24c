from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING

import pytest

from haul_ros import __version__
from haul_ros.cli import main as main_module
from haul_ros.cli.commands import COMMANDS
from haul_ros.cli.main import main
from tests.waiting import WAIT

if TYPE_CHECKING:
    from tests.cli.conftest import Haul


def test_the_version_is_that_of_the_package(haul: Haul) -> None:
    assert haul("--version").out == f"haul {__version__}\n"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "haul: the following arguments are required: COMMAND (see haul --help)"),
        (("run",), "haul: the following arguments are required: SCENARIO (see haul run --help)"),
        (
            ("run", "nothing"),
            "haul: nothing: no such scenario, expected a scenario file (YAML) or one of aar_unit_",
        ),
        (("run", "short.yaml", "--set", "speed"), "haul: override 'speed': expected KEY=VALUE"),
        (("run", "short.yaml", "--set", "initial_speed_kmh=-1"), "haul: "),
        (("run", "short.yaml", "-o", "no/where.mcap"), "haul: no/where.mcap: folder no does not exist"),
        (("run", "short.yaml", "--ros-args"), "haul: unrecognized arguments: --ros-args"),
        (("info", "none.mcap"), "haul: none.mcap: no such file"),
        (("info", "short.yaml"), "haul: short.yaml: not an MCAP file"),
        (("analyze", "short.yaml"), "haul: short.yaml: not an MCAP file"),
        (("brake", "master"), "haul: one of the arguments DEMAND --emergency --release-emergency is required"),
        (("brake", "master", "1", "--emergency"), "haul: argument --emergency: not allowed with argument DEMAND"),
        (("brake", "master", "much"), "haul: argument DEMAND: invalid float value: 'much'"),
    ],
)
def test_a_mistake_is_one_line_with_status_2_and_leaves_nothing(
    haul: Haul, tmp_path: Path, arguments: tuple[str, ...], message: str
) -> None:
    outcome = haul(*arguments)
    assert outcome.status == 2
    assert outcome.out == ""
    assert outcome.err.startswith(message)
    assert outcome.err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["short.yaml"]


def test_an_interrupted_command_ends_quietly_with_status_130(haul: Haul, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(_name: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(main_module, "resolve_name", interrupted)
    outcome = haul("scenarios")
    assert (outcome.status, outcome.out, outcome.err) == (130, "", "")


def test_a_reader_that_has_enough_is_no_error() -> None:
    command = [sys.executable, "-m", "haul_ros", "scenarios"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 1


HELP_OF_ALL = """
import contextlib, sys
from haul_ros.cli.commands import COMMANDS
from haul_ros.cli.main import main
for arguments in [[], *([command.name] for command in COMMANDS)]:
    with contextlib.suppress(SystemExit):
        main([*arguments, "--help"])
print(*sys.modules, file=sys.stderr)
"""


def test_reading_the_help_imports_nothing_that_carries_a_command_out() -> None:
    done = subprocess.run([sys.executable, "-c", HELP_OF_ALL], capture_output=True, text=True, check=True)
    assert done.stdout.count("usage: haul") == 1 + len(COMMANDS)
    imported = set(done.stderr.split())
    assert not {"numpy", "numba", "matplotlib", "mcap", "rclpy", "tqdm"} & imported
    assert {name for name in imported if name.startswith("haul_ros")} == {
        "haul_ros",
        "haul_ros.errors",
        "haul_ros.cli",
        "haul_ros.cli.commands",
        "haul_ros.cli.main",
        "haul_ros.cli.values",
        "haul_ros.ending",
        "haul_ros.resources",
        "haul_ros.version",
    }


def test_every_command_names_a_function_that_exists() -> None:
    assert all(callable(resolve_name(command.execute)) for command in COMMANDS)


def test_main_returns_the_status(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["scenarios"]) == 0
    assert main(["info", "no such file"]) == 2


@pytest.mark.no_cover
@pytest.mark.parametrize(
    ("redirection", "status", "told"),
    [
        (">/dev/full", 1, "haul: the output cannot be written: No space left on device\n"),
        (">&-", 0, ""),
        (">&- 2>&-", 0, ""),
    ],
)
@pytest.mark.parametrize("command", ["scenarios", "scenarios --json"])
def test_an_output_that_is_full_or_closed_ends_without_a_traceback(
    redirection: str, status: int, told: str, command: str
) -> None:
    done = subprocess.run(
        ["/bin/sh", "-c", f'exec "{sys.executable}" -m haul_ros {command} {redirection}'],
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stderr) == (status, told)


def test_control_characters_of_a_name_are_shown_and_not_obeyed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "\x1b[2Jno\x07"]) == 2
    assert "\\x1b[2Jno\\x07: no such scenario" in capsys.readouterr().err


@pytest.mark.parametrize("output", [".", "/", ".."])
def test_an_output_that_is_a_folder_is_refused(capsys: pytest.CaptureFixture[str], output: str) -> None:
    assert main(["run", "daqin_1_1_0", "-o", output]) == 2
    assert "expected a new" in capsys.readouterr().err


def test_a_folder_is_no_recording(capsys: pytest.CaptureFixture[str]) -> None:
    for command in (["info", "."], ["replay", ".."], ["recover", ".", "-o", "x.mcap"]):
        assert main(command) == 2
    assert capsys.readouterr().err.count("Is a directory") == 3
    assert main(["analyze", "/"]) == 2  # one may be a bag
    assert capsys.readouterr().err == "haul: /: a folder without files of a bag, expected .mcap or .db3 in it\n"


def test_a_name_that_the_output_cannot_encode_is_escaped(
    tmp_path: Path, short_train: str, environment: dict[str, str]
) -> None:
    (tmp_path / "\u00e9t\u00e9.yaml").write_text(short_train, "utf-8")
    command = [sys.executable, "-m", "haul_ros", "run", "\u00e9t\u00e9.yaml", "--set", "max_duration_s=0.1"]
    ascii_only = environment | {"PYTHONIOENCODING": "ascii"}
    done = subprocess.run(command, cwd=tmp_path, env=ascii_only, capture_output=True, text=True, timeout=WAIT)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(r"\xe9t\xe9: ")


def test_a_current_folder_that_is_gone_is_a_mistake_of_one_line(tmp_path: Path, environment: dict[str, str]) -> None:
    folder = tmp_path / "gone"
    folder.mkdir()
    run = f'rmdir "$PWD"; exec "{sys.executable}" -P -m haul_ros run daqin_1_1_0 -o run.mcap'
    done = subprocess.run(
        ["/bin/sh", "-c", run], cwd=folder, env=environment, capture_output=True, text=True, timeout=WAIT
    )
    expected = "haul: the current folder is gone, expected to be started in one that exists\n"
    assert (done.returncode, done.stdout, done.stderr) == (2, "", expected)

"""Every input that the user or somebody else writes has a bound: attacks at and beyond it, in little memory and time.

Each ends with one line and status 2, or runs. Recordings: tests/recording/test_integrity.py.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import sqlite3
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from haul_ros.scenario import load_scenario
from haul_ros.studies.case import CaseResult, key, simulate
from haul_ros.studies.store import ResultStore
from tests.ros.domain import own_domain
from tests.waiting import WAIT

pytestmark = pytest.mark.no_cover

MEMORY = 2 * 2**30
"""Bytes of address space, of which the libraries take some 600 MB."""
LONGEST = 30
"""Processor time [s] that an attack may take; what waits without end is ended by an alarm."""
RUN = """
import importlib, json, os, resource, signal, sys
from haul_ros.cli import study
from haul_ros.cli.main import main
from haul_ros.simulation.session import Session

for line in sys.stdin:  # a process for each, which has nothing left to import
    module, folder, environment, errors, arguments = json.loads(line)
    if not (child := os.fork()):
        os.chdir(folder)
        os.environ.update(environment)
        os.dup2(os.open(errors, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 2)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CPU, (LONGEST, LONGEST))
        signal.alarm(WAIT)
        sys.exit(importlib.import_module(module).main(arguments))
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""
for name, value in {"MEMORY": MEMORY, "LONGEST": LONGEST, "WAIT": int(WAIT)}.items():
    RUN = RUN.replace(name, str(value))


@pytest.fixture(scope="module")
def parent() -> Iterator[subprocess.Popen[str]]:
    """Of the processes that are attacked."""
    environment = {name: value for name, value in os.environ.items() if name != "COVERAGE_PROCESS_CONFIG"}
    with subprocess.Popen(
        [sys.executable, "-c", RUN], env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        yield process
        assert process.stdin is not None
        process.stdin.close()


class Attacked:
    """Programs of haul_ros in a folder, with little memory and time."""

    def __init__(self, parent: subprocess.Popen[str], folder: Path, errors: Path) -> None:
        self._parent = parent
        self._folder = folder
        self._errors = errors

    def run(self, *arguments: str, module: str = "haul_ros.cli.main") -> tuple[int, list[str]]:
        """Exit status and the lines on standard error, without those that rcl prints by itself."""
        assert self._parent.stdin is not None
        assert self._parent.stdout is not None
        asked = [module, str(self._folder), own_domain(), str(self._errors), arguments]
        self._parent.stdin.write(f"{json.dumps(asked)}\n")
        self._parent.stdin.flush()
        status = int(self._parent.stdout.readline())
        lines = self._errors.read_text("utf-8").splitlines()
        return status, [line for line in lines if "[rcl]" not in line and "compiling the model" not in line]

    def refused(self, *arguments: str, module: str = "haul_ros.cli.main") -> str:
        """The one line of a refusal."""
        status, lines = self.run(*arguments, module=module)
        assert (status, len(lines)) == (2, 1), lines[-5:]
        assert len(lines[0]) < 2000
        return lines[0]


@pytest.fixture
def attacked(parent: subprocess.Popen[str], tmp_path: Path, tmp_path_factory: pytest.TempPathFactory) -> Attacked:
    """What is attacked runs in ``tmp_path``."""
    return Attacked(parent, tmp_path, tmp_path_factory.mktemp("errors") / "errors")


def brief(value: object) -> str:
    """Name of a case: pytest hands it to every process that is started."""
    return str(value)[:40]


SHORT = "coupler: paper_set_b\nbrakes: paper_set_b\ninitial_speed_kmh: 80\nmax_duration_s: 0.05\n"
TRAIN = "consist: [{vehicle: SS4, role: master}, {vehicle: C80, count: 1999}]\n"


def scenarios() -> dict[str, tuple[str, str]]:
    """Texts of YAML files, and what is said of them, empty: they run."""
    commands = "\n".join(f"- {{at_s: {n / 1000}, locomotive: master, brake: {n % 10 / 10}}}" for n in range(6000))
    aliases = "\n".join(f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]" for n in range(1, 30))
    long_train = "consist:\n- {vehicle: SS4, role: master}\n" + "- {vehicle: C80, count: 2000}\n" * 1999
    return {
        "longest train and many commands": (f"{TRAIN}{SHORT}commands:\n{commands}\n", ""),
        "longest list of vehicles": (f"{long_train}{SHORT}", "must have 2 to 2000 vehicles"),
        "too many commands": (f"{TRAIN}{SHORT}commands:\n" + f"{commands}\n" * 2, "more than 50000 values and keys"),
        "aliases of aliases": (f"a0: &a0 [x, x]\n{aliases}\n{TRAIN}", "more than 50000 values and keys"),
        "too deep": ("a: " + "[" * 2000 + "]" * 2000, "nested too deeply"),
        "one long word": (f"{TRAIN}{SHORT}description: {'x' * 4_000_000}\n", "characters"),
        "one long comment": (f"{TRAIN}{SHORT}#{'x' * 4_190_000}", ""),
        "too long": ("#" + "x" * 2**22, "more than 4 MiB"),
        "brackets": ("[" * 2**21, "not"),
    }


@pytest.mark.slow
@pytest.mark.parametrize("name", scenarios())
def test_a_scenario_at_its_bounds_runs_or_is_refused_in_bounded_memory(
    name: str, tmp_path: Path, attacked: Attacked
) -> None:
    text, expected = scenarios()[name]
    (tmp_path / "case.yaml").write_text(text)
    if expected:
        assert expected in attacked.refused("run", "case.yaml", "--quiet")
    else:
        assert attacked.run("run", "case.yaml", "--quiet") == (0, [])


SWEEP = ("study", "sweep", "--scenario", "daqin_1_1_0", "--quiet", "-o", "out")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--over", "initial_speed_kmh=0:1:0.0000001"], "more than 1000000 values"),
        (["--over", "initial_spead_kmh=0:99.9999:0.0001"], "initial_spead_kmh: unknown key"),
        ([f"--over={name}=0:999999:1" for name in "abcdefgh"], "more than 1000000 cases"),
        (["--over", "initial_speed_kmh=" + ",".join(["1"] * 60_000)], "not a list of values"),
        ([*(f"--draw=a{n}=uniform(0,1)" for n in range(400)), "--samples", "1000000"], "10000000 drawn values"),
        ([*(f"--draw=a{n}=uniform(0,1)" for n in range(10)), "--samples", "1000000"], "a0: unknown key"),
        (["--draw", "a=uniform(0,1)", "--samples", "1000000000000"], "more than 1000000 cases"),
    ],
    ids=brief,
)  # fmt: skip
def test_a_sweep_at_its_bounds_is_refused_in_bounded_memory(
    words: list[str], expected: str, tmp_path: Path, attacked: Attacked
) -> None:
    assert expected in attacked.refused(*SWEEP, *words)
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("over: {" + ", ".join(f"k{n}: {{from: 0, to: 999999, step: 1}}" for n in range(5000)) + "}", "1000000 cases"),
        ("draw: {" + ", ".join(f"k{n}: {{uniform: [0, 1]}}" for n in range(7000)) + "}\nsamples: 1000000", "drawn"),
        ("over: {initial_speed_kmh: [" + "1, " * 49_000 + "2]}\nfitted: [{initial_speed_kmh: 3}]", "no case"),
    ],
    ids=brief,
)
def test_a_study_file_at_its_bounds_is_refused_in_bounded_memory(
    text: str, expected: str, tmp_path: Path, attacked: Attacked
) -> None:
    (tmp_path / "case.yaml").write_text(f"scenario: daqin_1_1_0\n{text}\n")
    assert expected in attacked.refused("study", "case.yaml", "-o", "out", "--quiet")


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("description=" + "x" * 10_000, ""),
        ("description=" + "x" * 120_000, "characters"),
        ("commands=[" + "1," * 60_000 + "]", "50000"),
        ("couplers.MT-2={a: " + "[" * 100_000, ""),
        ("a" + ".a" * 60_000 + "=1", ""),
    ],
    ids=brief,
)
def test_a_value_of_the_command_line_at_its_bounds_is_refused_in_bounded_memory(
    value: str, expected: str, tmp_path: Path, attacked: Attacked
) -> None:
    status, lines = attacked.run("run", "daqin_1_1_0", "--set", value, "--set", "max_duration_s=0.05", "--quiet")
    if value.startswith("description") and not expected:
        assert (status, lines) == (0, [])
    else:
        assert (status, len(lines)) == (2, 1)
        assert expected in lines[0]


HEAD = "/**:\n  ros__parameters:\n"


@pytest.mark.slow
@pytest.mark.skipif(not find_spec("rclpy"), reason="needs rclpy")
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (f"{HEAD}    x: [" + "1," * 3_000_000 + "1]\n", "more than 64 KiB, expected a parameter file of less"),
        (f"{HEAD}    scenaro: [" + "1," * 32_000 + "1]\n", "parameter scenaro is unknown"),
        (HEAD + "".join(f"    radio.k{n}: 1\n" for n in range(3000)), "is unknown"),
        (f"{HEAD}    scenario: " + "a" * 65_000 + "\n", "must be text of at most 4096 characters"),
        (f"{HEAD}    scenario: " + "[" * 50_000 + "\n", "cannot be started with these arguments"),
        ("a: &a [x, x]\nb: [*a, *a]\n", "cannot be started with these arguments"),
    ],
    ids=brief,
)
def test_a_parameter_file_at_its_bounds_is_refused_in_bounded_memory(
    text: str, expected: str, tmp_path: Path, attacked: Attacked
) -> None:
    (tmp_path / "p.yaml").write_text(text)
    arguments = ("--ros-args", "--params-file", "p.yaml", "-p", "record_path:=none")
    assert expected in attacked.refused(*arguments, module="haul_ros.ros.node")


@pytest.mark.skipif(not find_spec("rclpy"), reason="needs rclpy")
@pytest.mark.parametrize("name", ["/dev/zero", "missing.yaml", "."])
def test_a_parameter_file_without_end_or_that_is_none_is_refused(name: str, tmp_path: Path, attacked: Attacked) -> None:
    told = attacked.refused("--ros-args", "--params-file", name, module="haul_ros.ros.node")
    assert told.startswith(f"train_node: {name}: parameter file cannot be read: ")


CASE = {"initial_speed_kmh": 10, "max_duration_s": 0.05, "commands": []}
STUDY = ("study", "sweep", "--scenario", "daqin_1_1_0", "--over", "initial_speed_kmh=10", "--jobs", "1", "-o", "out",
         "--set", "max_duration_s=0.05", "--set", "commands=[]")  # fmt: skip
TABLE = "CREATE TABLE results (key TEXT PRIMARY KEY, name TEXT NOT NULL, result BLOB)"
ENDLESS = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n)"
NEVER = f"DELETE FROM results WHERE 0 < ({ENDLESS} SELECT count(*) FROM n)"


@pytest.mark.slow
@pytest.mark.parametrize(
    "statements",
    [
        [TABLE, "INSERT INTO results VALUES (:key, CAST(zeroblob(800000000) AS TEXT), 1)"],
        [f"CREATE VIEW results AS {ENDLESS} SELECT 'a' AS key, 'b' AS name, i AS result FROM n"],
        [TABLE, f"CREATE TRIGGER t AFTER INSERT ON results BEGIN {NEVER}; END"],
    ],
    ids=["name", "view", "trigger"],
)  # fmt: skip
def test_stored_results_that_are_too_large_or_without_end_are_refused(
    statements: list[str], tmp_path: Path, attacked: Attacked
) -> None:
    (tmp_path / "out").mkdir()
    with sqlite3.connect(tmp_path / "out" / "results.sqlite") as database:
        for statement in statements:
            database.execute(statement, {"key": key(load_scenario("daqin_1_1_0", CASE))} if ":key" in statement else {})
    database.close()
    assert "not usable as results of studies" in attacked.refused(*STUDY)


@pytest.mark.slow
def test_a_stored_result_that_is_too_large_is_computed_again(tmp_path: Path, attacked: Attacked) -> None:
    (tmp_path / "out").mkdir()
    with sqlite3.connect(tmp_path / "out" / "results.sqlite") as database:
        database.execute(TABLE)
        values = (key(load_scenario("daqin_1_1_0", CASE)),)
        database.execute("INSERT INTO results VALUES (?, 'a', zeroblob(800000000))", values)
    database.close()
    status, lines = attacked.run(*STUDY)
    assert (status, len(lines)) == (0, 1)
    assert "computed again" in lines[0]


def bomb() -> bytes:
    """An archive of a few kilobytes whose array takes gigabytes."""
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "|b1", "fortran_order": False, "shape": (3_000_000_000,)})
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("geared.npy", header.getvalue() + bytes(10_000_000))
    return packed.getvalue()


def misshapen() -> bytes:
    """A result whose arrays do not belong together."""
    found = simulate(load_scenario("daqin_1_1_0", CASE))
    return CaseResult(
        extremes=found.extremes, geared=found.geared[:3], locomotives=found.locomotives, stop_time=0.0, distance=0.0,
        relative_imbalance=0.0, unconverged_steps=0,
    ).to_bytes()  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("forge", [bomb, misshapen])
def test_a_forged_result_is_computed_again(forge: object, tmp_path: Path, attacked: Attacked) -> None:
    assert callable(forge)
    case, data = key(load_scenario("daqin_1_1_0", CASE)), forge()
    (tmp_path / "out").mkdir()
    with ResultStore(tmp_path / "out" / "results.sqlite") as store:
        store._database.execute(
            "INSERT INTO results VALUES (?, 'a', ?)", (case, hashlib.sha256(case.encode() + data).digest() + data)
        )
        store._database.commit()
    status, lines = attacked.run(*STUDY)
    assert (status, sum("computed again" in line for line in lines)) == (0, 1), lines

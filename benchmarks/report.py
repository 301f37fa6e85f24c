"""What the benchmarks print: tables, what has to hold, and the machine that it was measured on."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Check:
    """Something that has to hold: what, what was found, what is expected."""

    name: str
    found: str
    expected: str
    holds: bool


def machine(packages: Sequence[str]) -> dict[str, str]:
    """CPU model, cores, load before the benchmark, and versions of Python and of the given packages."""
    load, *_ = os.getloadavg()
    return {
        "CPU": _cpu_model(),
        "cores": str(os.cpu_count()),
        "load average (1 min)": f"{load:.2f}",
        "Python": platform.python_version(),
        **{name: version(name) for name in packages},
    }


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Text table, first column to the left, the others to the right."""
    widths = [max(map(len, column)) for column in zip(header, *rows, strict=True)]
    lines = [header, ["-" * width for width in widths], *rows]
    return "\n".join(_line(line, widths) for line in lines)


def checks_table(checks: Sequence[Check]) -> str:
    """The checks, one a line."""
    rows = [(check.name, check.found, check.expected, "holds" if check.holds else "FAILS") for check in checks]
    return table(("must hold", "found", "expected", ""), rows)


def pairs(facts: dict[str, str]) -> str:
    """Facts in one line."""
    return ", ".join(f"{name} {value}" for name, value in facts.items())


def _line(cells: Sequence[str], widths: Sequence[int]) -> str:
    first, *others = zip(cells, widths, strict=True)
    return "  ".join([first[0].ljust(first[1]), *(cell.rjust(width) for cell, width in others)]).rstrip()


def _cpu_model() -> str:
    """Name of the processor as Linux tells it, or what Python knows."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()

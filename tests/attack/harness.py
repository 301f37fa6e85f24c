"""How a case is tried: its own seed, its own folder, a time limit; how a whole attack is counted and gone on with."""

from __future__ import annotations

import contextlib
import io
import json
import os
import random
import shutil
import signal
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from enum import Enum
from pathlib import Path

from haul_ros.cli.main import main

LONGEST = 20.0
"""Wall time [s] after which a case counts as hung, where its part does not say otherwise."""


class Outcome(Enum):
    """How a case ended that found nothing."""

    RAN = "ran"
    REFUSED = "refused"


class Found(AssertionError):  # noqa: N818 (what it is called in all of the attack)
    """An error of the package."""


class Hung(BaseException):
    """Raised by the alarm: no handler of the package's own takes it for an error."""


Attack = Callable[[random.Random, Path], Outcome]


@dataclass(frozen=True, slots=True)
class Part:
    """One kind of attack: a case from its random numbers in an empty folder; ``share`` of all cases.

    A case counts as hung after ``longest`` [s]; ``lacking`` says what this machine lacks for it, empty: nothing.
    """

    name: str
    share: float
    attack: Attack
    longest: float = LONGEST
    lacking: Callable[[], str] = lambda: ""


@dataclass(slots=True)
class Tally:
    """What became of the cases of a part so far."""

    tried: int = 0
    refused: int = 0
    ran: int = 0
    failed: int = 0
    seconds: float = 0.0
    findings: list[str] = field(default_factory=list)


def haul(*arguments: str, statuses: Sequence[int] = (0,)) -> tuple[Outcome, str]:
    """Run a command in this process; Found unless it ends as it should. Its outcome, and what it printed.

    A refusal is status 2, one line that begins with ``haul: `` and no output but that of `haul info`.
    """
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status = main(arguments)
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else -1
    told = err.getvalue()
    if "Traceback" in told:
        raise Found(f"{arguments}: {told[-2000:]}")
    if status == 2:
        lines = [line for line in told.splitlines() if "compiling the model" not in line]
        if len(lines) != 1 or not lines[0].startswith("haul: ") or len(lines[0]) > 2000:
            raise Found(f"{arguments}: refused in other than one line: {told[-500:]!r}")
        return Outcome.REFUSED, out.getvalue()
    if status not in statuses:
        raise Found(f"{arguments}: status {status}: {out.getvalue()[-500:]!r} {told[-500:]!r}")
    return Outcome.RAN, out.getvalue()


@contextlib.contextmanager
def _alarm(seconds: float) -> Iterator[None]:
    def ring(_number: int, _frame: object) -> None:
        raise Hung

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def try_case(part: Part, seed: int, index: int) -> tuple[Outcome | None, str]:
    """One case; no outcome and what was found, if it found something."""
    folder = Path(tempfile.mkdtemp(prefix="haul_attack_"))
    before = Path.cwd()
    os.chdir(folder)
    try:
        with _alarm(part.longest):
            return part.attack(random.Random(f"{seed}:{part.name}:{index}"), folder), ""
    except Hung:
        return None, f"hung for {part.longest:g} s:\n{traceback.format_exc(limit=-6)}"
    except Found as found:
        return None, str(found)
    except BaseException:
        return None, traceback.format_exc(limit=-8)
    finally:
        os.chdir(before)
        shutil.rmtree(folder, ignore_errors=True)


class State:
    """Tallies by part, in a file if one is given, so that an attack goes on where it stopped."""

    def __init__(self, path: Path | None, seed: int) -> None:
        self._path = path
        self.tallies: dict[str, Tally] = {}
        self.seed = seed
        if path is not None and path.exists():
            data = json.loads(path.read_text("utf-8"))
            self.seed = data["seed"]
            self.tallies = {name: Tally(**entry) for name, entry in data["parts"].items()}

    def count(self, part: Part, outcome: Outcome | None, found: str, seconds: float) -> None:
        """Add a case."""
        tally = self.tallies.setdefault(part.name, Tally())
        if outcome is None:
            tally.failed += 1
            tally.findings.append(f"{part.name}:{tally.tried}: {found}")
        else:
            tally.ran += outcome is Outcome.RAN
            tally.refused += outcome is Outcome.REFUSED
        tally.tried += 1
        tally.seconds += seconds

    def save(self) -> None:
        """Write the file, whole or not at all."""
        if self._path is not None:
            data = {"seed": self.seed, "parts": {name: asdict(tally) for name, tally in self.tallies.items()}}
            new = self._path.with_name(f"{self._path.name}.new")
            new.write_text(json.dumps(data), "utf-8")
            new.replace(self._path)


def attack(parts: Sequence[Part], state: State, cases: int, until: float, tell: Callable[[str], None]) -> None:
    """Try so many cases in all, each part its share, those done before included; stops at a time [s, monotonic]."""
    whole = sum(part.share for part in parts)
    wanted = {part.name: round(cases * part.share / whole) for part in parts}
    for part in parts:
        state.tallies.setdefault(part.name, Tally())
    done = 0
    while time.monotonic() < until:
        open_parts = [part for part in parts if state.tallies[part.name].tried < wanted[part.name]]
        if not open_parts:
            break
        # Whichever is furthest behind: an attack that is stopped has tried something of everything
        part = min(open_parts, key=lambda part: (state.tallies[part.name].tried + 1) / wanted[part.name])
        tally, began = state.tallies[part.name], time.monotonic()
        outcome, found = try_case(part, state.seed, tally.tried)
        state.count(part, outcome, found, time.monotonic() - began)
        if outcome is None:
            tell(tally.findings[-1])
        done += 1
        if done % 200 == 0:
            state.save()
    state.save()

"""Values that nobody means, and changes that nobody makes."""

from __future__ import annotations

import random
from typing import Any

NUMBERS: tuple[float, ...] = (
    0, 1, -1, 2, -0.0, 0.5, 1e-3, 1e-9, 1e-300, 5e-324, 1e9, 1e18, 1e300, 1.7e308, float("inf"), -float("inf"),
    float("nan"), 2**31, 2**53 + 1, 2**63, -(2**63), 2**64, 10**400, 0.1, 2.0, 3.7, 100, 1000, 100000,
)  # fmt: skip
TEXTS = (
    "", " ", ".", "..", "/", "/dev/null", "/dev/zero", "~", "-", "--", "null", "true", "a b", "a\nb", "a\tb", "\x1b[2J",
    "\u202e", "\ufeff", "é" * 300, "x" * 5000, "😀", "%s%n", "{}", "[]", "{a: b", "[1, 2", "'", '"', "master",
    "slave_1", "slave_0", "slave_99999", "SS4", "C80", "paper_set_b", "MT-2", "daqin_1_1_0", "wagon_loaded", "1e5",
    "0x10", "1_000", "9" * 500, "9" * 5000, "=", "a=b", "a.b.c=1", "..=", ":", "a:b", "1:2:0", "0:1:1e-300",
    "uniform(1,2)", "\ud800",
)  # fmt: skip


def number(rng: random.Random) -> float:
    """Any number."""
    draw = rng.random()
    if draw < 0.5:
        return rng.choice(NUMBERS)
    if draw < 0.8:
        return float(rng.choice((-1, 1)) * 10.0 ** rng.uniform(-12, 12))
    return rng.randint(-5, 5000)


def text(rng: random.Random) -> str:
    """Any text that a file or an argument can hold."""
    found = rng.choice(TEXTS)
    return found.encode("utf-8", "replace").decode()


def value(rng: random.Random, depth: int = 0) -> Any:
    """Anything that YAML can say."""
    draw = rng.random()
    if draw < 0.5:
        return number(rng)
    if draw < 0.7:
        return text(rng)
    if draw < 0.8:
        return rng.choice((None, True, False))
    if depth > 3:
        return 0
    if draw < 0.9:
        return [value(rng, depth + 1) for _ in range(rng.randint(0, 3))]
    return {text(rng) or "a": value(rng, depth + 1) for _ in range(rng.randint(0, 3))}


def places(data: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Paths to everything in nested lists and mappings."""
    items: list[tuple[Any, Any]] = []
    if isinstance(data, dict):
        items = list(data.items())
    elif isinstance(data, list):
        items = list(enumerate(data))
    return [p for key, child in items for p in ((*path, key), *places(child, (*path, key)))]


def change(rng: random.Random, data: Any) -> None:
    """Change one place of nested lists and mappings: another value, one near it, none, a key twice or another name."""
    found = places(data)
    if not found:
        return
    *path, key = rng.choice(found)
    holder = data
    for part in path:
        holder = holder[part]
    before = holder[key]
    draw = rng.random()
    if draw < 0.35:
        holder[key] = value(rng)
    elif draw < 0.65 and isinstance(before, (int, float)) and not isinstance(before, bool):
        holder[key] = rng.choice((-1, 1, 1, 1)) * before * 10.0 ** rng.uniform(-3, 3)
    elif draw < 0.75:
        del holder[key]
    elif draw < 0.85:
        other = rng.choice(found)
        holder[key] = _at(data, other) if len(other) > len(path) + 1 or rng.random() < 0.2 else text(rng)
    elif isinstance(holder, dict):
        holder[text(rng) or "a"] = before
    else:
        holder.append(before)


def _at(data: Any, path: tuple[Any, ...]) -> Any:
    for part in path:
        data = data[part]
    return data if not isinstance(data, (dict, list)) else None


def change_bytes(rng: random.Random, data: bytes) -> bytes:
    """Some bytes flipped, inserted, taken out, doubled, or the rest cut off."""
    changed = bytearray(data)
    for _ in range(rng.choice((1, 1, 1, 2, 5))):
        at = rng.randrange(len(changed) + 1)
        length = rng.choice((1, 1, 2, 8, 100, 5000))
        match rng.randrange(6):
            case 0 | 1 if at < len(changed):
                changed[at] ^= 1 << rng.randrange(8)
            case 2:
                changed[at:at] = rng.randbytes(length)
            case 3:
                del changed[at : at + length]
            case 4:
                changed[at:at] = changed[at : at + length]
            case _:
                if rng.random() < 0.3:
                    del changed[at:]
                else:
                    changed[at : at + length] = rng.choice((b"\0", b"\xff", b"\x7f")) * length
    return bytes(changed)

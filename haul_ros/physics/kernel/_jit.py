"""How the kernel is compiled."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba import config

from haul_ros.physics.kernel._cache import SealedCacheFile

_Function = TypeVar("_Function", bound=Callable[..., Any])

# No test for a zero divisor at each division: a quotient that is not a number shows in the residual.
# Without numba's runtime nothing can be allocated, and no reference to an array is counted.
_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "forceinline": True, "_nrt": False}


@cache
def source_digest() -> str:
    """Short digest of all sources of the kernel: the same digest, the same machine code."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def inner(function: _Function) -> _Function:
    """Compile a function that only other compiled functions call.

    No fast-math anywhere: without reassociation and contraction the same run gives the same bits
    on every x86-64 machine, compiled or, with ``NUMBA_DISABLE_JIT=1``, interpreted.
    """
    compiled: _Function = numba.njit(**_OPTIONS)(function)
    return compiled


def interpreted(function: _Function) -> _Function:
    """An `inner` function for Python to call, now and then: compiled it would be ready after a second only.

    It must not call other functions of the kernel.
    """
    original: _Function = getattr(function, "py_func", function)
    return original


def outer(function: _Function) -> _Function:
    """Compile a function that only other compiled functions call, once, not again wherever it is called.

    What it does is worth a call; code that stands in many places takes long to compile.
    """
    compiled: _Function = numba.njit(**(_OPTIONS | {"forceinline": False}))(function)
    return compiled


def entry(function: _Function) -> _Function:
    """Compile a function that Python calls, once per installation: the machine code is cached.

    numba looks only at the file of the cached function itself, so a change in another kernel file
    would run stale code; the digest of all kernel sources in the name keeps the caches apart.
    """
    function.__qualname__ = f"{function.__name__}_{source_digest()}"
    try:
        compiled: _Function = numba.njit(cache=True, **_OPTIONS)(function)
        _seal(compiled)
    except RuntimeError:  # neither the installation nor the user's cache folder can be written
        compiled = numba.njit(**_OPTIONS)(function)
    return compiled


def _seal(compiled: Any) -> None:
    """Let its cache be checked before it is used; interpreted there is none."""
    if not config.DISABLE_JIT:  # type: ignore[attr-defined]
        compiled._cache._cache_file = SealedCacheFile.taking_over(compiled._cache._cache_file)


def is_cached(function: Any) -> bool:
    """Whether the machine code of an entry is at hand and whole; else its first call has to make it.

    That takes half a minute, more on a busy machine.

    Interpreted there is nothing to make.
    """
    if config.DISABLE_JIT:  # type: ignore[attr-defined]
        return True
    file = getattr(function._cache, "_cache_file", None)
    return bool(function.signatures) or (isinstance(file, SealedCacheFile) and file.whole())

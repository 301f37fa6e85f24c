"""Something that is done again and again while the thread that asked for it is busy."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def repeated(action: Callable[[], None], period: float) -> Iterator[None]:
    """Call ``action`` at once and every ``period`` [s] on a thread of its own, until the block is left."""
    left = threading.Event()

    def repeat() -> None:
        while True:
            action()
            if left.wait(period):
                return

    thread = threading.Thread(target=repeat, name="repeated", daemon=True)
    thread.start()
    try:
        yield
    finally:
        left.set()
        thread.join()

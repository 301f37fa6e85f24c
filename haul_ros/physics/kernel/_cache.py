"""Machine code on disk with a seal, so that damage is compiled again and never run."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from numba.core.caching import IndexDataCacheFile

_SEAL = ".sha256"


class SealedCacheFile(IndexDataCacheFile):
    """The files of a cached function beside the digests of their bytes; numba itself unpickles and runs what it finds.

    A seal tells damage, not malice: who may write there is trusted with the code that runs.
    """

    @classmethod
    def taking_over(cls, plain: Any) -> SealedCacheFile:
        """The same files as a cache of numba, from now on with a seal."""
        sealed = cls.__new__(cls)
        sealed.__dict__.update(plain.__dict__)
        return sealed

    @property
    def _index(self) -> Path:
        return Path(self._index_path)

    def whole(self) -> bool:
        """All files are there and are what was written."""
        try:
            sealed = self._index.with_name(self._index.name + _SEAL).read_text("ascii")
            return self._index.exists() and sealed == self._digests()
        except (OSError, ValueError):
            return False

    def load(self, key: Any) -> Any:
        """The entry of a signature; None: there is none, or the files are damaged and out of the way."""
        if not self.whole():
            self._index.unlink(missing_ok=True)
            return None
        return super().load(key)  # type: ignore[no-untyped-call]

    def save(self, key: Any, data: Any) -> None:
        """Keep an entry, and seal all of them."""
        super().save(key, data)  # type: ignore[no-untyped-call]
        seal = self._index.with_name(self._index.name + _SEAL)
        with self._open_for_write(str(seal)) as file:
            file.write(self._digests().encode())

    def _digests(self) -> str:
        """A line for the index and each file of machine code."""
        code = sorted(self._index.parent.glob(f"{self._index.name.removesuffix('.nbi')}.*.nbc"))
        return "".join(
            f"{hashlib.sha256(path.read_bytes()).hexdigest()} {path.name}\n" for path in [self._index, *code]
        )
